#include "world/faults/fault_schedule.hpp"

#include <map>
#include <vector>

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

using faults::Kind;
using faults::Quantity;
using namespace std::chrono_literals;

/// A cell that is as the test says.
class MadeUpCell final : public CellFacts {
 public:
  [[nodiscard]] int robots() const override { return 2; }
  [[nodiscard]] GripFacts grip(int robot) const override {
    return grips[static_cast<std::size_t>(robot)];
  }
  [[nodiscard]] const std::string& type_of(int body) const override {
    return types[static_cast<std::size_t>(body)];
  }
  [[nodiscard]] bool beam_broken(int) const override { return broken; }
  [[nodiscard]] double quantity(Quantity, int, int) const override { return value; }
  [[nodiscard]] std::optional<double> distance_to_belt_end(int) const override { return to_end; }

  std::vector<GripFacts> grips{{}, {}};
  std::vector<std::string> types{"small", "large"};
  bool broken = false;
  double value = 0;
  std::optional<double> to_end;
};

class Schedule : public testing::Test {
 protected:
  std::uint64_t inject(Kind kind, api::FaultTrigger trigger = {},
                       std::optional<SimTime> duration = {}, int trigger_robot = -1) {
    FaultSpec spec;
    spec.kind = kind;
    spec.robot = 0;
    spec.body = 0;
    spec.trigger = trigger;
    spec.trigger_robot = trigger_robot;
    spec.duration = duration;
    for (std::size_t i = 0; i < faults::info(kind).parameter_count(); ++i) {
      spec.values[i] = faults::info(kind).parameters[i].fallback;
    }
    const auto id = schedule_.inject(++ticket_, {}, spec);
    return id ? *id : 0;
  }

  FaultSchedule::Changes step() {
    ++step_;
    return schedule_.advance(step_ * 1ms, step_, cell_);
  }

  /// Steps until something begins or ends; at most so many.
  FaultSchedule::Changes step_until_change(int most) {
    FaultSchedule::Changes changes;
    for (int i = 0; i < most && changes.begun.empty() && changes.ended.empty(); ++i) {
      changes = step();
    }
    return changes;
  }

  const api::InjectedFault& shown(std::uint64_t id) const {
    for (const auto& fault : schedule_.list()->all) {
      if (fault.id == id) return fault;
    }
    throw std::runtime_error("no such fault");
  }

  FaultSchedule schedule_;
  MadeUpCell cell_;
  api::Ticket ticket_ = 0;
  std::uint64_t step_ = 0;
};

TEST_F(Schedule, BeginsAtTheNextStepAndEndsAfterItsTime) {
  EXPECT_TRUE(schedule_.idle());
  EXPECT_EQ(schedule_.list(), nullptr);
  const auto id = inject(Kind::kBeltJam, {}, SimTime(10ms));
  EXPECT_FALSE(schedule_.idle());
  EXPECT_EQ(shown(id).state, api::FaultState::kPending);
  EXPECT_EQ(step().begun, std::vector{id});
  EXPECT_EQ(shown(id).begin_step, 1U);
  EXPECT_EQ(schedule_.active().size(), 1U);
  const auto before = schedule_.list();
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(step().any());
  EXPECT_EQ(schedule_.list(), before) << "nothing new, nothing copied";
  EXPECT_EQ(step().ended, std::vector{id});
  EXPECT_EQ(shown(id).state, api::FaultState::kEnded);
  EXPECT_EQ(shown(id).end_step, 11U);
  EXPECT_TRUE(schedule_.idle());
}

TEST_F(Schedule, WithoutATimeItLastsUntilItIsEnded) {
  const auto id = inject(Kind::kBeltJam);
  step();
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(step().any());
  ASSERT_TRUE(schedule_.end(id));
  EXPECT_EQ(step().ended, std::vector{id});
  const auto again = schedule_.end(id);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(schedule_.end(99));
}

TEST_F(Schedule, OneThatWaitsCanBeGivenUp) {
  const auto id = inject(Kind::kBeltJam, api::AtTime{10s});
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(step().any());
  ASSERT_TRUE(schedule_.end(id));
  EXPECT_EQ(step().ended, std::vector{id});
  EXPECT_FALSE(shown(id).begin_step);
  EXPECT_NE(shown(id).note.find("given up"), std::string::npos);
}

TEST_F(Schedule, MomentaryOnesAreOverAtOnce) {
  const auto id = inject(Kind::kProtectiveStop);
  const auto changes = step();
  EXPECT_EQ(changes.begun, std::vector{id});
  EXPECT_EQ(changes.ended, std::vector{id});
  ASSERT_NE(schedule_.spec(id), nullptr) << "for who carries it out";
  schedule_.set_note(id, "nothing was there");
  EXPECT_EQ(shown(id).note, "nothing was there");
  EXPECT_TRUE(schedule_.active().empty());
}

TEST_F(Schedule, AtATimeAndAtOnceWhereThatIsOver) {
  const auto later = inject(Kind::kBeltJam, api::AtTime{5ms});
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(step().any());
  EXPECT_EQ(step().begun, std::vector{later});
  const auto over = inject(Kind::kBeltSlip, api::AtTime{2ms});
  EXPECT_EQ(step().begun, std::vector{over});
}

TEST_F(Schedule, TheNthGraspSinceTheInjection) {
  cell_.grips[0].held_body = 0;
  step();
  const auto id = inject(Kind::kGripperLeak, api::WhenGrasped{"fanuc", 2}, {}, 0);
  EXPECT_FALSE(step().any()) << "what is held already was grasped before";
  cell_.grips[0].held_body = -1;
  step();
  cell_.grips[0].held_body = 1;
  EXPECT_FALSE(step().any()) << "the first";
  cell_.grips[0].held_body = -1;
  step();
  cell_.grips[1].held_body = 0;
  EXPECT_FALSE(step().any()) << "the other robot's";
  cell_.grips[0].held_body = 1;
  EXPECT_EQ(step().begun, std::vector{id});
}

TEST_F(Schedule, PlacedIsLetGoWithTheGripperOpen) {
  const auto any = inject(Kind::kBeltJam, api::WhenPlaced{"large", ""});
  const auto second = inject(Kind::kBeltSlip, api::WhenPlaced{"large", "motoman"}, {}, 1);
  const auto let_go = [&](int robot, int body, bool open) {
    auto& grip = cell_.grips[static_cast<std::size_t>(robot)];
    grip = {body, false};
    EXPECT_TRUE(step().begun.empty());
    grip = {-1, open};
    return step().begun;
  };
  EXPECT_TRUE(let_go(0, 1, false).empty()) << "dropped";
  EXPECT_TRUE(let_go(0, 0, true).empty()) << "another type";
  EXPECT_EQ(let_go(0, 1, true), std::vector{any});
  EXPECT_EQ(let_go(1, 1, true), std::vector{second});
}

TEST_F(Schedule, ABeamAndACrossingNeedAChange) {
  cell_.broken = true;
  cell_.value = 7;
  const auto beam = inject(Kind::kBeltJam, api::WhenBeamBroken{"eye"});
  const auto above =
      inject(Kind::kBeltSlip, api::WhenCrossing{Quantity::kBeltTravel, "", 1, true, 5});
  const auto below =
      inject(Kind::kBeltWrongSpeed, api::WhenCrossing{Quantity::kBeltTravel, "", 1, false, 5});
  EXPECT_FALSE(step().any()) << "so at the injection already";
  cell_.value = 4;
  EXPECT_EQ(step().begun, std::vector{below});
  cell_.value = 6;
  EXPECT_EQ(step().begun, std::vector{above});
  cell_.broken = false;
  EXPECT_FALSE(step().any());
  cell_.broken = true;
  EXPECT_EQ(step().begun, std::vector{beam});
}

TEST_F(Schedule, AReportedEventIsForThoseThatWaitForIt) {
  const auto order = inject(Kind::kBeltJam, api::WhenReported{"order-submitted"});
  const auto other = inject(Kind::kBeltSlip, api::WhenReported{"shift-over"});
  schedule_.report("lunch");
  EXPECT_FALSE(step().any());
  schedule_.report("order-submitted");
  EXPECT_EQ(step().begun, std::vector{order});
  EXPECT_EQ(shown(other).state, api::FaultState::kPending);
}

TEST_F(Schedule, AGripperThatDropsOpensForAWhileAtEachGrasp) {
  inject(Kind::kGripperDrops);  // a second after the grasp, for a second
  step();
  const auto open = [&] { return schedule_.active().at(0).open_until != SimTime{}; };
  for (int i = 0; i < 2000; ++i) step();
  EXPECT_FALSE(open()) << "nothing is held";
  for (int grasp = 0; grasp < 2; ++grasp) {
    cell_.grips[0].held_body = 1;
    for (int i = 0; i < 990; ++i) step();
    EXPECT_FALSE(open());
    for (int i = 0; i < 20; ++i) step();
    EXPECT_TRUE(open());
    cell_.grips[0].held_body = -1;
    for (int i = 0; i < 960; ++i) step();
    EXPECT_TRUE(open());
    for (int i = 0; i < 40; ++i) step();
    EXPECT_FALSE(open());
  }
}

TEST_F(Schedule, ATrayCatchesWhereItIsTold) {
  inject(Kind::kTrayJammed);  // 0.4 m before the end
  step();
  cell_.to_end = 0.5;
  EXPECT_FALSE(step().shifted);
  EXPECT_FALSE(schedule_.active().at(0).caught);
  cell_.to_end = 0.39;
  EXPECT_TRUE(step().shifted);
  EXPECT_TRUE(schedule_.active().at(0).caught);
  cell_.to_end = 0.8;
  EXPECT_FALSE(step().shifted) << "caught it stays, though the belt runs back";
  EXPECT_TRUE(schedule_.active().at(0).caught);
}

TEST_F(Schedule, KeepsNoMoreThanItsLimits) {
  for (std::size_t i = 0; i < api::kMaxOpenFaults; ++i) {
    EXPECT_NE(inject(Kind::kBeltJam, api::AtTime{10s}), 0U);
  }
  EXPECT_EQ(inject(Kind::kBeltJam), 0U);
  for (std::uint64_t id = 1; id <= api::kMaxOpenFaults; ++id) EXPECT_TRUE(schedule_.end(id));
  step();
  for (int i = 0; i < 40; ++i) {
    inject(Kind::kProtectiveStop);
    step();
  }
  EXPECT_EQ(schedule_.list()->all.size(), api::kMaxPastFaults);
  EXPECT_EQ(schedule_.list()->all.back().id, api::kMaxOpenFaults + 40) << "the latest are kept";
}

TEST_F(Schedule, ACopyGoesOnTheSame) {
  inject(Kind::kGripperDrops);
  inject(Kind::kBeltJam, api::AtTime{700ms}, SimTime(300ms));
  inject(Kind::kBeltSlip, api::WhenGrasped{"fanuc", 1}, {}, 0);
  for (int i = 0; i < 100; ++i) step();
  const FaultSchedule saved = schedule_;
  const auto run = [&](FaultSchedule schedule) {
    std::vector<std::uint64_t> steps;
    MadeUpCell cell;
    for (std::uint64_t at = 101; at < 3000; ++at) {
      cell.grips[0].held_body = at > 500 ? 1 : -1;
      if (schedule.advance(at * 1ms, at, cell).any()) steps.push_back(at);
    }
    return steps;
  };
  const auto once = run(saved);
  EXPECT_GE(once.size(), 5U);
  EXPECT_EQ(run(saved), once);
}

}  // namespace
}  // namespace aprsim::world
