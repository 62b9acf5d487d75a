#pragma once

#include <algorithm>

#include "engine/linalg/compensated.h"
#include "engine/maps/frame_moments.h"

namespace stiefel {

/// What stands under Q in a state: S = Q̇Λ or Q̇ itself.
enum class Under { S, Qdot };

/// The one pass over the columns of a state that a step of RattleStiefel makes, a few columns at a
/// time: from the multipliers Y and Y′ the new state, and at once the moments of it,
///
///     Q′ = Q + (hS + YQ)Λ⁻¹,   S′ = S + (YQ + Y′Q′)/h.
///
/// `n` is the number of rows where that is small, else Eigen::Dynamic. `inverse` is Λ⁻¹, followed
/// by zeros up to a multiple of the width. Nothing of size N lives here.
template <class Scalar, Arithmetic arithmetic, Under under, int n>
class FramePass {
 public:
  using State = Accumulator<Matrix<Scalar>, arithmetic>;
  static constexpr Eigen::Index width = n == Eigen::Dynamic ? 64 : 16;

  explicit FramePass(Eigen::Index rows)
      : n_(rows), moments_(rows), Y_(rows, rows), Y1_(rows, rows) {
    for (Tile* tile : {&Q_, &S_, &Q_carry_, &S_carry_, &kick_, &change_, &V_, &G_, &H_, &sum_})
      tile->setZero(rows, width);
  }

  void measure(const State& x, const Vector<Scalar>& inverse, FrameMoments<Scalar>& moments) {
    moments_.set_zero();
    for (Eigen::Index j = 0; j < x.value.cols(); j += width) {
      load(x, j);
      add_moments(inverse.template segment<width>(j));
    }
    moments.assign(moments_);
  }

  void advance(State& x, const Vector<Scalar>& inverse, Scalar h, const Matrix<Scalar>& Y,
               const Matrix<Scalar>& Y1, FrameMoments<Scalar>& moments) {
    Y_ = Y;
    Y1_ = Y1;
    moments_.set_zero();
    for (Eigen::Index j = 0; j < x.value.cols(); j += width) {
      const auto w = inverse.template segment<width>(j);
      load(x, j);
      kick_.noalias() = Y_ * Q_;
      if constexpr (under == Under::S)
        change_ = (h * S_ + (h * S_carry_ + kick_)) * w.asDiagonal();
      else
        change_ = h * S_ + (h * S_carry_ + kick_ * w.asDiagonal());
      add(Q_, Q_carry_);
      change_.noalias() = Y1_ * Q_;
      change_ = (kick_ + change_) / h;
      if constexpr (under == Under::Qdot) change_ = change_ * w.asDiagonal();
      add(S_, S_carry_);
      store(x, j);
      add_moments(w);
    }
    moments.assign(moments_);
  }

 private:
  using Tile = Eigen::Matrix<Scalar, n, width>;
  using Square = Eigen::Matrix<Scalar, n, n>;
  static constexpr bool compensated = arithmetic == Arithmetic::compensated;

  void load(const State& x, Eigen::Index j) {
    copy(
        x.value, j, [](auto& tile, auto&& block) { tile = block; }, Q_, S_);
    if constexpr (compensated)
      copy(
          x.carry, j, [](auto& tile, auto&& block) { tile = block; }, Q_carry_, S_carry_);
  }
  void store(State& x, Eigen::Index j) {
    copy(
        x.value, j, [](auto& tile, auto&& block) { block = tile; }, Q_, S_);
    if constexpr (compensated)
      copy(
          x.carry, j, [](auto& tile, auto&& block) { block = tile; }, Q_carry_, S_carry_);
  }

  /// Between a tile and the columns of x that are there; the rest of a last tile is zero.
  template <class Block, class Move>
  void copy(Block& x, Eigen::Index j, Move&& move, Tile& top, Tile& bottom) {
    const Eigen::Index there = std::min(width, x.cols() - j);
    if (there == width) {
      move(top, x.template block<n, width>(0, j, n_, width));
      move(bottom, x.template block<n, width>(n_, j, n_, width));
    } else {
      auto top_there = top.leftCols(there), bottom_there = bottom.leftCols(there);
      top.rightCols(width - there).setZero();
      bottom.rightCols(width - there).setZero();
      move(top_there, x.block(0, j, n_, there));
      move(bottom_there, x.block(n_, j, n_, there));
    }
  }

  /// value ← value + change, with what rounding takes away in the carry, as Accumulator does.
  void add(Tile& value, Tile& carry) {
    if constexpr (compensated) {
      change_ += carry;
      sum_ = value + change_;
      carry = sum_ - value;
      carry = (value - (sum_ - carry)) + (change_ - carry);
      value = sum_;
    } else {
      value += change_;
    }
  }

  template <class Weights>
  void add_moments(const Weights& w) {
    if constexpr (under == Under::S)
      V_ = S_ * w.asDiagonal();
    else
      V_ = S_;
    G_ = Q_ * w.asDiagonal();
    H_ = V_ * w.asDiagonal();
    accumulate(moments_.QQ[0], Q_, Q_);
    accumulate(moments_.QQ[1], G_, Q_);
    accumulate(moments_.QQ[2], G_, G_);
    accumulate(moments_.QV[0], Q_, V_);
    accumulate(moments_.QV[1], G_, V_);
    accumulate(moments_.QV[2], G_, H_);
    accumulate(moments_.VV[0], V_, V_);
    accumulate(moments_.VV[1], H_, V_);
    change_ = G_ * w.asDiagonal();
    accumulate(moments_.QQ[3], change_, G_);
  }

  static void accumulate(Square& sum, const Tile& A, const Tile& B) {
    if constexpr (n == Eigen::Dynamic)
      sum.noalias() += A * B.transpose();
    else
      sum += A.lazyProduct(B.transpose());
  }

  Eigen::Index n_;
  FrameMoments<Scalar, n> moments_;
  Square Y_, Y1_;
  Tile Q_, S_, Q_carry_, S_carry_, kick_, change_, V_, G_, H_, sum_;
};

}  // namespace stiefel
