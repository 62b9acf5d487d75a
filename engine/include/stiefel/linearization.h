#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <stop_token>

#include "stiefel/run_status.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"
#include "stiefel/violation.h"

namespace stiefel {

/// What a Linearization moves.
struct LinearizationDescription {
  /// Tangent vectors at the first state, one a column; absent: the basis of the tangent space, so
  /// that the result is the whole state transition matrix.
  std::optional<Eigen::MatrixXd> vectors;
  /// Whether a vector is given, and returned, as a matrix of the shape of the state's blocks
  /// stacked by rows (δQ over δM, δQ over δS, …), its numbers row by row; otherwise by its
  /// coordinates.
  bool as_blocks = false;
  /// Adds columns with the derivatives of the state by λ_1 … λ_N, and by the step, at constant
  /// blocks of the first state. The S of a scene on V(n, N) is made tangent, which depends on Λ.
  bool by_inertia = false, by_step = false;
};

/// The derivative of a scene's computed steps, not of the flow that they approximate, along a
/// motion, applied to tangent vectors, for the methods and systems that have it
/// (MethodOnSystem::has_tangent). The derivatives of implicit steps follow from their equations
/// (implicit function theorem). The states and their bits are those of the simulation.
///
/// The coordinates of a tangent vector:
///
///     (Q, M)          η, then δM, with δQ = Qη; N = 3: as axial vectors (x, y, z), else the
///                     elements i < j row by row; η is the skew part of Q⁻¹δQ
///     other states    those of an orthonormal basis of the tangent space in ⟨A, B⟩ = tr(AᵀB); it
///                     differs from state to state and is returned
///
/// With derivatives by Λ a state (Q, S) on V(n, N) has n(n + 1)/2 further coordinates, the last
/// ones: the states of other Λ lie beside its tangent space.
///
/// A scene given by `body` has its vectors in the caller's axes.
class Linearization {
 public:
  /// The largest number of rows × columns of a state for which coordinates are offered.
  static constexpr std::int64_t largest_in_coordinates = 1024;

  /// Refuses ensembles, methods and systems without a derivative, and vectors that do not fit or
  /// are not tangent. Throws Stopped (stop.h).
  static std::expected<std::unique_ptr<Linearization>, Violations> make(
      const Scene& scene, const LinearizationDescription& description, const Simulation& start);
  virtual ~Linearization() = default;

  /// Advances `motion` by `steps` ≥ 0 steps and the vectors with it. Ends at the last good state,
  /// with the vectors there.
  virtual RunStatus advance(Simulation& motion, std::int64_t steps,
                            const std::stop_token& stop = {}) = 0;

  /// Returns the vectors at the state of `motion`, one a column, in coordinates or as blocks.
  virtual Eigen::MatrixXd vectors(const Simulation& motion) const = 0;
  /// Returns the basis of the coordinates at the state of `motion`: column k is the vector with the
  /// coordinates e_k as blocks.
  virtual Eigen::MatrixXd basis(const Simulation& motion) const = 0;
  /// Returns that of vectors that start there, which are tangent.
  virtual Eigen::MatrixXd start_basis(const Simulation& motion) const = 0;

  /// The rows and columns of a vector as blocks, and the number of vectors, those of parameters
  /// included.
  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return cols_; }
  Eigen::Index count() const { return count_; }

 protected:
  Eigen::Index rows_ = 0, cols_ = 0, count_ = 0;
};

/// Returns an upper bound of the bytes of a Linearization with so many vectors, which are given or
/// asked for in coordinates or as blocks; 0 for a system without tangents.
std::uint64_t linearization_bytes(const Scene& scene, std::int64_t vectors, bool in_coordinates);

}  // namespace stiefel
