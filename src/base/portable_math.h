#pragma once
// sin, cos and tan from additions and multiplications alone. The C library picks its version at run time by
// processor, so its last bit differs between machines; these give the same bits everywhere.

namespace cloth {

/// Within 2e-16 of the true value (relative to 1) for |degrees| ≤ 1e6; exact at multiples of 90.
double sin_degrees(double degrees);
double cos_degrees(double degrees);
/// sin_degrees / cos_degrees.
double tan_degrees(double degrees);

}  // namespace cloth
