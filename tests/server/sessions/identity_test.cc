// The identity of a scene: any change of any field changes it.
#include "server/sessions/identity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "stiefel/scene_fields.h"

namespace stiefel::server {
namespace {

// A value for each type of field, and values next to it.

void fill(std::string& out) { out = "name"; }
void fill(double& out) { out = 0.25; }
void fill(int& out) { out = 3; }
void fill(std::vector<double>& out) { out = {1, -2, 0.5}; }
void fill(std::map<std::string, Block>& out) {
  const RowMatrix real = RowMatrix::Constant(2, 3, 0.5), imaginary = RowMatrix::Constant(2, 3, 2);
  out["P"] = Block(real, imaginary);
  out["Q"] = Block(real);
}
template <Description T>
void fill(T& out);
template <class T>
void fill(std::optional<T>& out) {
  fill(out.emplace());
}
template <Description T>
void fill(T& out) {
  for_each_field<T>([&](const auto& field) { fill(out.*field.member); });
}

std::vector<std::string> changes(const std::string& x) { return {"", x + "x", "Name"}; }
std::vector<double> changes(double x) { return {-x, 0.0, -0.0, std::nextafter(x, 1)}; }
std::vector<int> changes(int x) { return {0, x + 1, -x}; }
std::vector<std::vector<double>> changes(const std::vector<double>& x) {
  std::vector<std::vector<double>> out = {{}, {x.rbegin(), x.rend()}};
  for (std::size_t k = 0; k < x.size(); ++k) {
    out.push_back(x);
    out.back()[k] = std::nextafter(x[k], 10);
  }
  out.push_back(x);
  out.back().push_back(0);
  return out;
}
std::vector<std::map<std::string, Block>> changes(const std::map<std::string, Block>& x) {
  std::vector<std::map<std::string, Block>> out(6, x);
  out[0].clear();
  out[1].erase("Q");
  out[2]["R"] = out[2].extract("Q").mapped();
  out[3]["Q"].values.resize(3, 2);
  out[3]["Q"].values.setConstant(0.5);
  out[4]["P"].imaginary.resize(0, 0);
  out[5]["Q"].values(1, 2) = std::nextafter(0.5, 1);
  return out;
}
template <Description T>
std::vector<T> changes(const T& x);
template <class T>
std::vector<std::optional<T>> changes(const std::optional<T>& x) {
  std::vector<std::optional<T>> out = {std::nullopt};
  for (auto& changed : changes(*x)) out.push_back(std::move(changed));
  return out;
}
template <Description T>
std::vector<T> changes(const T& x) {
  std::vector<T> out;
  for_each_field<T>([&](const auto& field) {
    for (auto& changed : changes(x.*field.member)) {
      out.push_back(x);
      out.back().*field.member = std::move(changed);
    }
  });
  return out;
}

SceneDescription filled() {
  SceneDescription out;
  fill(out);
  return out;
}

TEST(Identity, ChangesWithEveryField) {
  const SceneDescription whole = filled();
  std::set<std::string> all = {identity_of(whole)};
  std::size_t count = 1;
  for_each_field<SceneDescription>([&](const auto& field) {
    const auto changed = changes(whole.*field.member);
    EXPECT_GE(changed.size(), 3u) << field.name;
    for (const auto& value : changed) {
      SceneDescription other = whole;
      other.*field.member = value;
      EXPECT_TRUE(all.insert(identity_of(other)).second)
          << field.name << ": the identity is another field's or has not changed";
      ++count;
    }
  });
  EXPECT_EQ(all.size(), count);
  EXPECT_GE(count, 80u);
}

TEST(Identity, IsTheSameOfTheSame) { EXPECT_EQ(identity_of(filled()), identity_of(filled())); }

TEST(Identity, TellsWhichFieldNumbersAreIn) {
  SceneDescription one, other;
  one.inertia = {1, 2};
  one.inertia_u = {3};
  other.inertia = {1};
  other.inertia_u = {2, 3};
  EXPECT_NE(identity_of(one), identity_of(other));
}

TEST(Identity, TellsMembersFromNone) {
  SceneDescription one = filled();
  one.members.reset();
  SceneDescription ensemble = one;
  ensemble.members = 1;
  EXPECT_NE(identity_of(one), identity_of(ensemble));
}

}  // namespace
}  // namespace stiefel::server
