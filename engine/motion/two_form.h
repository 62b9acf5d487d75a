#pragma once

#include <array>
#include <functional>
#include <string_view>

#include "engine/numbers/scalar.h"
#include "stiefel/catalogue.h"
#include "stiefel/scene.h"

namespace stiefel {

/// A tangent space with its two-form: one of structure/tangent_spaces.h.
struct FormSpace {
  /// Returns the part of G that is tangent at x.
  std::function<Dense(const Dense& x, const Dense& G)> tangent;
  std::function<double(const Dense& x, const Dense& u, const Dense& v)> form;
};

template <class Space>
FormSpace space_of(Space of) {
  return {[of](const Dense& x, const Dense& G) { return of.tangent(x, G); },
          [of](const Dense& x, const Dense& u, const Dense& v) { return of.form(x, u, v); }};
}

/// A two-form of the papers, for SystemEntry::two_forms: its description, the blocks of the state
/// that it reads, and the form itself.
struct TwoForm {
  FormInfo info;
  std::array<std::string_view, 2> blocks;
  FormSpace (*space)(const Scene&);
};

}  // namespace stiefel
