#pragma once
// How much memory there is.

#include <cstddef>
#include <string>

namespace cloth {

/// Memory that this process may still take without swapping: what the machine has free, what its control
/// group and its address space leave [byte].
std::size_t available_memory();

/// The address space of this process [byte].
std::size_t address_space();

/// "1.5 GB", "20 MB".
std::string memory_text(double bytes);

}  // namespace cloth
