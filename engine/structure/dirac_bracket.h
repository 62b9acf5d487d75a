#pragma once

#include "engine/structure/tangent_spaces.h"
#include "stiefel/diagnosis.h"

namespace stiefel {

/// A product of functions tr AᵀQ + tr BᵀP and its gradients in the metric ⟨X, Y⟩ = ½ tr(XᵀY).
struct Jet {
  double value;
  Matrix<double> by_Q, by_P;
};
Jet jet_of(const PairFactors& function, const Matrix<double>& Q, const Matrix<double>& P);

/// Returns the Dirac bracket {F|S, K|S} at (Q, P) ∈ S, [RB] (3.15): the Poisson bracket of the form
/// Ω_gl|S, for functions given on gl(N) × gl(N). With ⟨X, Y⟩ = ½ tr(XᵀY) and R = QPᵀ it is
///
///     ⟨∇₂K, ∇₁F⟩ − ⟨∇₁K, ∇₂F⟩ − ½⟨Q(∇₂K)ᵀ + (∇₂K)Qᵀ, (I + R⊗Rᵀ)⁻¹ R(P(∇₁F)ᵀ + (∇₁F)Pᵀ)⟩
///                             + ½⟨P(∇₁K)ᵀ + (∇₁K)Pᵀ, (I + R⊗Rᵀ)⁻¹ (Q(∇₂F)ᵀ + (∇₂F)Qᵀ)R⟩.
double dirac_bracket(const Matrix<double>& Q, const Matrix<double>& P, const PairFactors& F,
                     const PairFactors& K);

}  // namespace stiefel
