#pragma once
// Arithmetic without denormal numbers. Internal.

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace cloth {

/// While it lives, numbers of this thread below the least normal one (1.2e-38 in single precision) become 0
/// instead of denormal, with which processors reckon many times slower. On processors without SSE it does
/// nothing: there, only the time differs by much.
class FlushToZero {
  public:
#if defined(__SSE2__)
    FlushToZero() : before_(_mm_getcsr()) {
        constexpr unsigned flush_to_zero = 0x8000, denormals_are_zero = 0x0040;
        _mm_setcsr(before_ | flush_to_zero | denormals_are_zero);
    }
    ~FlushToZero() {
        _mm_setcsr(before_);
    }
#else
    FlushToZero() = default;
#endif
    FlushToZero(const FlushToZero&) = delete;
    FlushToZero& operator=(const FlushToZero&) = delete;

  private:
#if defined(__SSE2__)
    unsigned before_;
#endif
};

}  // namespace cloth
