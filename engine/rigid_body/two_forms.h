#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "stiefel/catalogue.h"
#include "stiefel/scene.h"

namespace stiefel {

/// A tangent space with its two-form: one of tangent_spaces.h.
struct FormSpace {
  using Dense = Eigen::MatrixXd;
  /// Returns the part of G that is tangent at x.
  std::function<Dense(const Dense& x, const Dense& G)> tangent;
  std::function<double(const Dense& x, const Dense& u, const Dense& v)> form;
};

/// A two-form of the papers: its description, the blocks of the state that it reads, and the form
/// itself.
struct TwoForm {
  FormInfo info;
  std::array<std::string_view, 2> blocks;
  FormSpace (*space)(const Scene&);
};

}  // namespace stiefel
