#pragma once
#include <array>
#include <span>
#include <vector>

#include "core/base/rows.h"
#include "elastin/core/model/body.h"

namespace elastin {

/// The connections of each molecule, ascending.
Rows connections_of_molecules(int molecules, const Connections& connections);

/// Connection of each pair of nodes of each cell, cell by cell, pairs in the order 01 02 … 12 …; `nodes` those of all
/// cells, `of_each` of one. Throws InputError if a pair is no connection of the body.
std::vector<int> connections_of_pairs(const Connections& connections, std::span<const int> nodes, int of_each);
/// The same, −1 where a pair is no connection.
std::vector<int> connections_of_some_pairs(const Connections& connections, std::span<const int> nodes, int of_each);

/// Connection of each corner pair of each cell, order 01 02 12 or 01 02 03 12 13 23.
/// Throws InputError if a cell's edge is no connection of the body.
template <int corners>
std::vector<std::array<int, corners*(corners - 1) / 2>> connections_of_each_cell(
    const Connections& connections, const std::vector<std::array<int, static_cast<std::size_t>(corners)>>& cells);

}  // namespace elastin
