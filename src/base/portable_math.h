#pragma once
// sin, cos, tan, exp and log from additions and multiplications alone. The C library picks its version at run
// time by processor, so its last bit differs between machines; these give the same bits everywhere.

namespace cloth {

/// Within 2e-16 of the true value (relative to 1) for |degrees| ≤ 1e6; exact at multiples of 90.
double sin_degrees(double degrees);
double cos_degrees(double degrees);
/// sin_degrees / cos_degrees.
double tan_degrees(double degrees);

/// e to the power x, within 1e-15 of it relatively; 0 or infinite where a double cannot hold it.
double portable_exp(double x);
/// Natural logarithm of a positive finite number, within 1e-15 (relative to the greater of it and 1).
double portable_log(double x);

}  // namespace cloth
