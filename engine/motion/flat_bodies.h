#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/motion/packed_bodies.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// The members of an ensemble of bodies in three dimensions, as numbers: a Scene and a Simulation
/// are made only of a member that is asked for them. A state is what Simulation::save gives for one
/// member. Thread-safe.
class FlatBodies {
 public:
  virtual ~FlatBodies() = default;

  const Scene& ensemble() const { return ensemble_; }
  std::size_t size() const { return size_; }
  /// Returns the simulation of the first member at step 0.
  const Simulation& first() const { return *first_; }

  bool can_be_packed(std::size_t member) const;
  int lanes() const { return lanes_; }
  /// Packs at most as many members as there are lanes, in their order. Packs of the members in
  /// their order are made once for all who ask.
  std::shared_ptr<const PackedBodies> pack(std::span<const std::size_t> members) const;

  /// Writes the state of a member at step 0.
  virtual void start(std::size_t member, std::span<double> state) const = 0;
  // Read a state of a member, as Simulation does.
  virtual void write(std::size_t member, std::span<const double> state, std::size_t index,
                     std::span<double> out) const = 0;
  virtual void invariants(std::size_t member, std::span<const double> state,
                          InvariantList& out) const = 0;
  virtual std::optional<double> orthogonality(std::size_t member,
                                              std::span<const double> state) const = 0;
  virtual double rate(std::size_t member, std::span<const double> state) const = 0;

 protected:
  explicit FlatBodies(const Scene& ensemble)
      : ensemble_(ensemble),
        size_(ensemble.members().size()),
        first_(make_simulation(ensemble_.members().front())) {}
  /// Packs the members that can be packed, which are given in their order.
  void pack_all(std::vector<std::size_t> packable, int lanes);

 private:
  virtual std::shared_ptr<const PackedBodies> make_pack(
      std::span<const std::size_t> members) const = 0;

  const Scene ensemble_;
  std::size_t size_;
  std::unique_ptr<Simulation> first_;
  int lanes_ = 1;
  std::vector<std::size_t> packable_;
  std::vector<std::shared_ptr<const PackedBodies>> packs_;  ///< of these, all full but the last
};

/// Returns the members of an ensemble as numbers; null where they are no bodies in three dimensions
/// that can be packed.
std::shared_ptr<const FlatBodies> flat_bodies(const Scene& ensemble);
bool has_flat_bodies(const Scene& ensemble);

/// Reads states of one member after another as its simulation would. It cannot advance.
class FlatReader final : public Simulation {
 public:
  explicit FlatReader(std::shared_ptr<const FlatBodies> bodies) : bodies_(std::move(bodies)) {
    fields_ = bodies_->first().fields();
    block_count_ = bodies_->first().block_count();
  }
  /// Goes to a state, which must outlive what is read.
  void go_to(std::size_t member, std::int64_t step, std::span<const double> state) {
    member_ = member;
    step_ = step;
    state_ = state;
  }

  bool direct() const override { return bodies_->first().direct(); }
  std::size_t saved_size() const override { return state_.size(); }
  void save(std::span<double> out) const override { std::ranges::copy(state_, out.begin()); }
  void write(std::size_t index, std::span<double> out) const override {
    bodies_->write(member_, state_, index, out);
  }
  void invariants(InvariantList& out) const override { bodies_->invariants(member_, state_, out); }
  std::optional<double> orthogonality() const override {
    return bodies_->orthogonality(member_, state_);
  }
  double rate() const override { return bodies_->rate(member_, state_); }
  double step_cost() const override { return bodies_->first().step_cost(); }

  std::int64_t map_steps() const override { return 0; }
  RunStatus advance(std::int64_t, const std::stop_token&) override;
  void restore(std::int64_t, std::span<const double>) override;
  std::optional<double> largest_step(double) const override { return std::nullopt; }
  std::optional<Eigen::MatrixXd> image(const Eigen::MatrixXd&) const override {
    return std::nullopt;
  }

 private:
  std::shared_ptr<const FlatBodies> bodies_;
  std::size_t member_ = 0;
  std::span<const double> state_;
};

}  // namespace stiefel
