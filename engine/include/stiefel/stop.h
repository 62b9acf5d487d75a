#pragma once

#include <exception>
#include <limits>
#include <optional>
#include <stop_token>
#include <type_traits>
#include <utility>

namespace stiefel {

/// Thrown by a computation within a StopScope before it has a result, when a token requests a stop
/// or the scope's work is used up.
class Stopped : public std::exception {
 public:
  const char* what() const noexcept override { return "the computation was told to stop"; }
};

/// A thread's turn to compute, where threads take turns.
class Turn {
 public:
  /// Is called at each stop point of the thread: returns when the thread may compute on. May block,
  /// and requests the stop of a token where the computation is not wanted any more.
  virtual void pass() = 0;

 protected:
  ~Turn() = default;
};

/// Makes the computations of this thread stoppable while the scope lives. A long computation calls
/// `stop_point` before each of its pieces, such as a product of large matrices or an iteration of a
/// solver; `stop_point` throws Stopped when the scope's token requests a stop. Scopes nest, and
/// `stop_point` checks all of them. Other threads have scopes of their own.
///
/// A function of this library that takes a token opens a scope for it, and documents what it
/// returns when the token stops it. `Simulation::advance` never throws Stopped: it returns to the
/// last good state. Every other function (Scene::resolve, choose_method, convert, dirac_bracket,
/// ...) lets Stopped pass.
class StopScope {
 public:
  static constexpr double unlimited = std::numeric_limits<double>::infinity();

  /// `token` must outlive the scope. Stopped is also thrown once the operations announced to
  /// `stop_point` exceed `most_work`; their count is the same on every machine.
  explicit StopScope(const std::stop_token& token, double most_work = unlimited)
      : token_(&token), most_(most_work) {}
  explicit StopScope(std::stop_token&&, double = unlimited) = delete;
  /// Also passes the turn at each stop point, before it checks the token. Both must outlive the
  /// scope.
  StopScope(const std::stop_token& token, Turn& turn) : token_(&token), turn_(&turn) {}

  /// Opens a scope in which nothing is stopped, whatever the outer scopes say: for code that could
  /// not restore its state.
  static StopScope nothing() { return StopScope(); }

  StopScope(const StopScope&) = delete;
  StopScope& operator=(const StopScope&) = delete;
  ~StopScope() { innermost() = outer_; }

  /// The operations announced so far, and whether they exceed `most_work`.
  double operations() const { return operations_; }
  bool used_up() const { return operations_ > most_; }

  /// Checks this thread's scopes before a piece of work of `operations` operations.
  static void look(double operations) {
    for (StopScope* scope = innermost(); scope != nullptr && scope->token_ != nullptr;
         scope = scope->outer_)
      scope->look_here(operations);
  }

 private:
  StopScope() = default;

  static StopScope*& innermost() {
    static thread_local constinit StopScope* scope = nullptr;
    return scope;
  }

  void look_here(double operations) {
    operations_ += operations;
    if (turn_ != nullptr) turn_->pass();
    if (used_up() || token_->stop_requested()) throw Stopped();
  }

  const std::stop_token* token_ = nullptr;  ///< null: nothing is stopped
  Turn* turn_ = nullptr;
  double most_ = unlimited, operations_ = 0;
  StopScope* const outer_ = std::exchange(innermost(), this);
};

/// Marks a point where a computation may stop, before a piece of work of about `operations`
/// operations (a multiplication with its addition counts as one). Throws Stopped when one of this
/// thread's scopes requires it.
inline void stop_point(double operations = 0) { StopScope::look(operations); }

/// Returns `work()`, run within a scope of `token`; nullopt when that token stopped it.
template <class Work>
auto unless_stopped(const std::stop_token& token, Work&& work)
    -> std::optional<std::invoke_result_t<Work>> {
  try {
    const StopScope scope(token);
    return work();
  } catch (const Stopped&) {
    if (!token.stop_requested()) throw;
    return std::nullopt;
  }
}

}  // namespace stiefel
