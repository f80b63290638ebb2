#pragma once
// Where barrier contact's time goes.

namespace cloth {

/// Wall time [s]. Looked at by no computation.
struct ContactTimes {
    double detection = 0.0;  ///< what may touch, and what is free
    double assembly = 0.0;   ///< Hessians
    double factorization = 0.0;
    double solution = 0.0;    ///< conjugate gradients
    double evaluation = 0.0;  ///< objective and gradient

    ContactTimes& operator+=(const ContactTimes& t) {
        detection += t.detection;
        assembly += t.assembly;
        factorization += t.factorization;
        solution += t.solution;
        evaluation += t.evaluation;
        return *this;
    }
};

}  // namespace cloth
