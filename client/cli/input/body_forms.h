#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace stiefel::cli {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The blocks of an initial state, each with a matrix for each member.
using Blocks = std::map<std::string, std::vector<RowMatrix>>;

/// Returns the numbers of a list, which may be nested. Throws BadInput where one is no number.
std::vector<double> numbers_of(const std::string& place, const nlohmann::json& list);

/// Returns a block as a matrix for each member; nullopt for null, a complex block, and one that
/// cannot be divided among the members. Throws BadInput.
std::optional<std::vector<RowMatrix>> stacked(const std::string& place, const nlohmann::json& block,
                                              std::size_t members);

/// Writes the forms of `body` that the proto does not have as `inertia_tensor`, `attitude` and
/// `angular_velocity`. `path`: what stands before the names in errors. Throws BadInput.
void write_out_body(const std::string& path, nlohmann::json& body, bool normalize);

/// Makes the state of a system fit: the nearest orthonormal frames, skew M, and the nearest tangent
/// velocities. Throws BadInput for what is further than 0.01 from that.
void make_fit(const std::string& path, const std::string& system,
              const std::vector<double>& inertia, Blocks& blocks);

}  // namespace stiefel::cli
