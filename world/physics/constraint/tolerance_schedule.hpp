#pragma once

#include <algorithm>
#include <cmath>

#include "world/physics/constraint/contact_problem.hpp"
#include "world/physics/constraint/contact_solver_parameters.hpp"

namespace aprsim::physics {

/// The residual that is accepted: smaller of bodies at rest, larger of contacts of unactuated
/// bodies, and larger the more Newton steps a solve has taken.
class ToleranceSchedule {
 public:
  ToleranceSchedule(const ContactSolverParameters& parameters, bool is_at_rest)
      : tolerance_m_s_(parameters.tolerance_m_s *
                       (is_at_rest ? parameters.rest_tolerance_factor : 1)),
        max_m_s_(parameters.max_tolerance_m_s),
        start_(parameters.schedule_start_newton_steps),
        decade_(parameters.schedule_decade_newton_steps),
        relaxed_slack_m_s_(
            std::max(0.0, parameters.relaxed_tolerance_m_s - parameters.tolerance_m_s)) {}

  /// The tolerance after so many Newton steps.
  [[nodiscard]] double after(int newton_steps) const {
    if (newton_steps <= start_) return tolerance_m_s_;
    const double grown = tolerance_m_s_ * std::pow(10, (newton_steps - start_) / decade_);
    return std::max(tolerance_m_s_, std::min(max_m_s_, grown));
  }
  /// The residual to compare with it: contacts of unactuated bodies have a slack.
  [[nodiscard]] double excess_m_s(const ContactResidual& residual) const {
    return std::max(residual.actuated_m_s, residual.relaxed_m_s - relaxed_slack_m_s_);
  }
  [[nodiscard]] bool accepts(const ContactResidual& residual, int newton_steps) const {
    return excess_m_s(residual) <= after(newton_steps);
  }

 private:
  double tolerance_m_s_, max_m_s_, start_, decade_, relaxed_slack_m_s_;
};

}  // namespace aprsim::physics
