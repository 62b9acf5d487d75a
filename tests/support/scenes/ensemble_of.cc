#include "tests/support/scenes/ensemble_of.h"

namespace stiefel::testing {
namespace {

void append(std::vector<double>& all, const std::vector<double>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

void append(RowMatrix& all, const RowMatrix& more) {
  RowMatrix both(all.rows() + more.rows(), more.cols());
  if (all.size() > 0) both.topRows(all.rows()) = all;
  both.bottomRows(more.rows()) = more;
  all = both;
}

}  // namespace

SceneDescription ensemble_of(const std::vector<SceneDescription>& scenes) {
  SceneDescription all = scenes.front();
  all.members = static_cast<int>(scenes.size());
  for (std::size_t b = 1; b < scenes.size(); ++b) {
    const SceneDescription& one = scenes[b];
    append(all.inertia, one.inertia);
    append(all.inertia_u, one.inertia_u);
    append(all.inertia_v, one.inertia_v);
    for (auto& [name, block] : all.initial) {
      append(block.values, one.initial.at(name).values);
      if (block.imaginary.size() > 0) append(block.imaginary, one.initial.at(name).imaginary);
    }
    if (!all.body) continue;
    append(all.body->inertia_tensor, one.body->inertia_tensor);
    append(all.body->moments, one.body->moments);
    append(all.body->attitude, one.body->attitude);
    append(all.body->angular_velocity, one.body->angular_velocity);
  }
  return all;
}

}  // namespace stiefel::testing
