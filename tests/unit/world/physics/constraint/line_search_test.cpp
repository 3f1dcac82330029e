#include "world/physics/constraint/line_search.hpp"

#include <algorithm>

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

const ContactSolverParameters kParameters;

TEST(LineSearch, TakesTheFullStepWhereTheFunctionStillFalls) {
  EXPECT_EQ(search_line(kParameters, [](double step) { return step - 2; }), 1);
}

TEST(LineSearch, TakesTheFullStepNearTheMinimum) {
  EXPECT_EQ(search_line(kParameters, [](double step) { return step - 0.9; }), 1);
}

TEST(LineSearch, FindsTheMinimumBeforeTheFullStep) {
  for (const double minimum : {1e-3, 0.1, 0.5, 0.8}) {
    // Slopes that rise evenly, steeply behind a kink, and as a cube.
    const auto even = [&](double step) { return step - minimum; };
    const auto kinked = [&](double step) {
      return step - minimum + 1e4 * std::max(0.0, step - minimum);
    };
    const auto cubic = [&](double step) { return std::pow(step, 3) - std::pow(minimum, 3); };
    EXPECT_LE(std::abs(even(search_line(kParameters, even))), 0.1 * std::abs(even(0)));
    EXPECT_LE(std::abs(kinked(search_line(kParameters, kinked))), 0.1 * std::abs(kinked(0)));
    EXPECT_LE(std::abs(cubic(search_line(kParameters, cubic))), 0.1 * std::abs(cubic(0)));
  }
}

TEST(LineSearch, EndsWithinItsBracketAfterItsSteps) {
  // A slope that jumps has no zero.
  ContactSolverParameters few;
  few.max_line_search_steps = 5;
  int evaluations = 0;
  const double step = search_line(few, [&](double at) {
    ++evaluations;
    return at < 0.3 ? -1.0 : 10.0;
  });
  EXPECT_GT(step, 0);
  EXPECT_LT(step, 0.3);
  EXPECT_EQ(evaluations, 2 + 5);
}

}  // namespace
}  // namespace aprsim::physics
