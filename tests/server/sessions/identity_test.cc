// The identity of a scene, and how a resolved one differs from the one given.
#include "server/sessions/identity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <set>
#include <utility>

#include "server/sessions/checkpoints/secrets.h"
#include "server/sessions/scene_fields.h"
#include "tests/server/scene_cases.h"

namespace stiefel::server {
namespace {

/// Is called while a value is another one.
using See = std::function<void()>;

// A value for each type of field; `vary` gives it values next to it, one after
// another.

void fill(std::string& out) { out = "name"; }
void fill(double& out) { out = 0.25; }
void fill(int& out) { out = 3; }
void fill(std::vector<double>& out) { out = {1, -2, 0.5}; }
void fill(std::map<std::string, Block>& out) {
  out["P"] = Block(RowMatrix::Constant(2, 3, 0.5), RowMatrix::Constant(2, 3, 2));
  out["Q"] = Block(RowMatrix::Constant(2, 3, 0.5));
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

template <class T>
void with(T& x, T other, const See& see) {
  std::swap(x, other);
  see();
  std::swap(x, other);
}
void vary(std::string& x, const See& see) {
  for (const std::string& other : {std::string(), x + "x"}) with(x, other, see);
}
void vary(double& x, const See& see) {
  for (const double other : {-x, std::nextafter(x, 10)}) with(x, other, see);
}
void vary(int& x, const See& see) { with(x, x + 1, see); }
void vary(std::vector<double>& x, const See& see) {
  for (double& one : x) vary(one, see);
  for (const double zero : {0.0, -0.0}) {
    x.push_back(zero);
    see();
    x.pop_back();
  }
  with(x, {}, see);
  with(x, {x.rbegin(), x.rend()}, see);
}
void vary(std::map<std::string, Block>& x, const See& see) {
  using Map = std::map<std::string, Block>;
  vary(x["Q"].values(1, 2), see);
  vary(x["P"].imaginary(0, 0), see);
  const Block& Q = x["Q"];
  for (const Map& other :
       {Map(), Map{{"P", x["P"]}}, Map{{"P", Q}, {"Q", Q}}, Map{{"P", x["P"]}, {"R", Q}},
        Map{{"P", x["P"]}, {"Q", Block(RowMatrix::Constant(3, 2, 0.5))}}})
    with(x, other, see);
}
template <Description T>
void vary(T& x, const See& see);
template <class T>
void vary(std::optional<T>& x, const See& see) {
  vary(*x, see);
  with(x, {}, see);
}
template <Description T>
void vary(T& x, const See& see) {
  for_each_field<T>([&](const auto& field) { vary(x.*field.member, see); });
}

TEST(Identity, ChangesWithEveryField) {
  SceneDescription scene;
  fill(scene);
  const std::string whole = identity_of(scene);
  std::set<std::string> all = {whole};
  std::size_t count = 1;
  vary(scene, [&] {
    EXPECT_TRUE(all.insert(identity_of(scene)).second) << "change " << count;
    ++count;
  });
  EXPECT_GE(count, 80u);
  EXPECT_EQ(identity_of(scene), whole) << "the same of the same";
}

TEST(Identity, TellsWhichFieldNumbersAreIn) {
  SceneDescription one, other;
  one.inertia = {1, 2};
  one.inertia_u = {3};
  other.inertia = {1};
  other.inertia_u = {2, 3};
  EXPECT_NE(identity_of(one), identity_of(other));
}

TEST(Identity, IsMadeOfTheDigestOfFips180) {
  EXPECT_EQ(to_hexadecimal(sha256("abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

}  // namespace
}  // namespace stiefel::server
