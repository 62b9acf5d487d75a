#pragma once

#include <algorithm>
#include <array>

#include "engine/numbers/parallel.h"
#include "engine/numbers/scalar.h"

namespace stiefel {

/// Anderson's acceleration of a fixed point x = g(x) where the eigenvalues of g′ lie near the
/// imaginary axis. The errors of x_k and x_{k−2} then have opposite signs, and only the difference
/// of these two iterates accelerates:
///
///     x_{k+1} = g_k − γ(g_k − g_{k−2}),    γ = argmin ‖f_k − γ(f_k − f_{k−2})‖,    f = g(x) − x,
///
/// Each iteration removes about a third more of the error than a plain sweep. Allocates at
/// construction only.
template <class Scalar>
class LaggedAnderson {
 public:
  explicit LaggedAnderson(Eigen::Index size) : along_((size + chunk - 1) / chunk), square_(along_) {
    f_.fill(Vector<Scalar>::Zero(size));
    g_ = f_;
  }

  void restart() { k_ = 0; }

  /// Sets x to the next iterate. `g` must hold g(x) and is overwritten.
  void operator()(Vector<Scalar>& x, Vector<Scalar>& g) {
    Vector<Scalar>&f = f_[k_ % 2], &earlier = g_[k_ % 2];
    by_chunks(x.size(), [&](Eigen::Index k, auto here) {
      const auto now = here(g) - here(x);
      along_(k) = now.dot(now - here(f));
      square_(k) = (now - here(f)).squaredNorm();
      here(f) = now;
    });
    Scalar along = 0, square = 0;
    for (Eigen::Index k = 0; k < along_.size(); ++k) {
      along += along_(k);
      square += square_(k);
    }
    if (k_ < 2 || !(square > 0)) {
      copy_numbers(g.data(), g.size(), x.data());
    } else {
      const Scalar gamma = along / square;
      by_chunks(x.size(), [&](Eigen::Index, auto here) {
        here(x) = here(g) - gamma * (here(g) - here(earlier));
      });
    }
    earlier.swap(g);
    ++k_;
  }

 private:
  static constexpr Eigen::Index chunk = 512;  // stays in the cache

  /// Works through long vectors in chunks.
  template <class Work>
  static void by_chunks(Eigen::Index size, Work&& work) {
    in_ranges(size, chunk, static_cast<double>(size), [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index start = begin; start < end; start += chunk)
        work(start / chunk, [start, length = std::min(chunk, end - start)](Vector<Scalar>& v) {
          return v.segment(start, length);
        });
    });
  }

  std::size_t k_ = 0;
  std::array<Vector<Scalar>, 2> f_, g_;  ///< f and g of the last two iterations
  Vector<Scalar> along_, square_;        ///< sums over the chunks
};

}  // namespace stiefel
