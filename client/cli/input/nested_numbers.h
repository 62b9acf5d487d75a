#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "client/cli/input/strict_syntax.h"

namespace stiefel::cli {

/// Returns the numbers of nested lists as one list. Throws BadInput with the place where inner
/// lists differ in length.
nlohmann::json flat(const std::string& place, const nlohmann::json& nested);

/// Returns the object with rows, cols and values of a matrix that is given as its rows, as the rows
/// of each member, as the numbers of a single row, or as an object whose `values` and `imaginary`
/// are rows. Throws BadInput as `flat` does.
nlohmann::json matrix_of(const std::string& place, const nlohmann::json& given);

/// Writes numbers in nested lists, such as the matrix [[1, 0], [0, 1]] or [1, 0, 0], as the proto
/// has them: objects with rows, cols and values, and flat lists. In an ensemble a matrix may have
/// one more level. `path`: what stands before the names in errors. Throws BadInput with the path of
/// lists of different length.
void write_out_numbers(const Types& types, const std::string& path, nlohmann::json& object);

/// Returns the `values` of an object as nested lists with these lengths, from the outermost; with
/// `imaginary` an object whose `values` and `imaginary` are such lists. Empty lists where the
/// number of the values is another.
nlohmann::ordered_json nested_matrix(const nlohmann::ordered_json& matrix,
                                     std::span<const std::size_t> lengths);

/// Returns numbers of an array as nested lists with these lengths, beginning with number `first`;
/// of a complex one an object of two, `values` and `imaginary`.
nlohmann::ordered_json as_lists(const v1::Tensor& array, std::span<const std::size_t> lengths,
                                std::size_t first = 0);
/// Returns all numbers of an array as nested lists of its shape.
nlohmann::ordered_json as_lists(const v1::Tensor& array);

/// Writes the matrices in the JSON of a message of this type as their rows.
void write_as_rows(const google::protobuf::Descriptor& type, nlohmann::ordered_json& json);

}  // namespace stiefel::cli
