#pragma once
#include <cstdint>

namespace elastin {

/// The count as a number that molecules, connections, cells and slots have: 32 bits, at most 2³¹ − 1. Throws InputError
/// where it is larger: "3000000000 connections are more than 2147483647, the most that a body can have".
int numbered(std::int64_t count, const char* what);

}  // namespace elastin
