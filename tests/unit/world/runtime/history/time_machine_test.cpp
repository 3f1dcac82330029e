// Any moment of a recorded run, worked out bit for bit.

#include "world/runtime/history/time_machine.hpp"

#include <future>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/recorded_demo.hpp"
#include "world/cell/state_bytes.hpp"

namespace aprsim::world {
namespace {

Result<api::PastMoment> ask(api::History& history, api::Moment moment) {
  auto answer = std::make_shared<std::promise<Result<api::PastMoment>>>();
  auto there = answer->get_future();
  history.ask(moment,
              [answer](Result<api::PastMoment> past) { answer->set_value(std::move(past)); });
  if (there.wait_for(std::chrono::seconds(60) * test::kPatience) != std::future_status::ready) {
    return fail(ErrorCode::kUnavailable, "test", "no answer");
  }
  return there.get();
}

/// Twelve seconds of both robots and the belt.
class PastOfARun : public testing::Test {
 protected:
  static constexpr std::uint64_t kSteps = 12'000;

  PastOfARun() {
    std::mt19937 random(7);
    std::set<std::uint64_t> chosen{0, 1, kSteps, 2000, 2001, 9999};
    while (chosen.size() < 40) chosen.insert(random() % kSteps);
    test::RecordedDemo demo(world_, records_, 3);
    keep(chosen);
    while (world_.step_count() < kSteps) {
      demo.advance();
      keep(chosen);
    }
    records_.reach({0, kSteps});
  }

  void keep(const std::set<std::uint64_t>& chosen) {
    if (!chosen.contains(world_.step_count())) return;
    states_[world_.step_count()] = to_bytes(world_.save());
    world_.write(snapshots_[world_.step_count()]);
  }

  std::shared_ptr<const scene::Scene> scene_ = test::load_scene("aprs");
  World world_{scene_, 3};
  HistoryRecords records_{{}};
  Bookmarks bookmarks_;
  TimeMachine machine_{scene_, records_, bookmarks_, nullptr};
  std::map<std::uint64_t, std::string> states_;
  std::map<std::uint64_t, api::Snapshot> snapshots_;
};

TEST_F(PastOfARun, IsTheSameAtRandomMomentsInAnyOrder) {
  std::vector<std::uint64_t> steps;
  for (const auto& [step, state] : states_) steps.push_back(step);
  std::ranges::shuffle(steps, std::mt19937(11));
  for (const std::uint64_t step : steps) {
    const auto past = ask(machine_, {0, step});
    ASSERT_TRUE(past) << past.error().message;
    EXPECT_EQ(to_bytes(*past->state) == states_[step], true) << "step " << step;
    const api::Snapshot& then = snapshots_[step];
    EXPECT_EQ(past->snapshot->step, step);
    EXPECT_EQ(past->snapshot->time, then.time);
    EXPECT_EQ(past->snapshot->contact_count, then.contact_count) << "step " << step;
    ASSERT_EQ(past->snapshot->contacts.size(), then.contacts.size()) << "step " << step;
    for (std::size_t i = 0; i < then.contacts.size(); ++i) {
      EXPECT_EQ(past->snapshot->contacts[i].f_W, then.contacts[i].f_W) << "step " << step;
    }
    EXPECT_EQ(past->snapshot->robots[0].action.ticket, then.robots[0].action.ticket);
    EXPECT_EQ(past->snapshot->robots[1].gripper.force_n, then.robots[1].gripper.force_n);
  }
}

TEST_F(PastOfARun, GoesOnFromAMomentAsTheRunDid) {
  const auto past = ask(machine_, {0, 9999});
  ASSERT_TRUE(past);
  World again(scene_, 99);
  again.restore(*past->state);
  again.step();
  World other(scene_, 99);
  const auto next = ask(machine_, {0, 10'000});
  ASSERT_TRUE(next);
  other.restore(*next->state);
  // Nothing was commanded in between.
  EXPECT_EQ(again.state_hash(), other.state_hash());
}

TEST_F(PastOfARun, StepsBackAndForth) {
  std::map<std::uint64_t, std::string> first;
  for (std::uint64_t step = 7000; step < 7010; ++step) {
    const auto past = ask(machine_, {0, step});
    ASSERT_TRUE(past);
    first[step] = to_bytes(*past->state);
  }
  for (std::uint64_t step = 7009; step >= 7000; --step) {
    const auto past = ask(machine_, {0, step});
    ASSERT_TRUE(past);
    EXPECT_TRUE(to_bytes(*past->state) == first[step]) << step;
  }
}

TEST_F(PastOfARun, KeepsItsStatesWithinTheirMemory) {
  const std::uint64_t limit = 3 * world_.save().bytes();
  TimeMachine machine(scene_, records_, bookmarks_, nullptr, limit);
  EXPECT_EQ(machine.state_bytes(), 0U);
  for (std::uint64_t step = 500; step <= 6000; step += 500) {
    ASSERT_TRUE(ask(machine, {0, step}));
    EXPECT_GT(machine.state_bytes(), 0U);
    EXPECT_LE(machine.state_bytes(), limit) << step;
  }
}

TEST_F(PastOfARun, RefusesWhatIsNotKept) {
  for (const api::Moment moment : {api::Moment{0, kSteps + 1}, api::Moment{1, 0}}) {
    const auto past = ask(machine_, moment);
    ASSERT_FALSE(past);
    EXPECT_EQ(past.error().code, ErrorCode::kNotFound);
    EXPECT_EQ(past.error().field, "moment");
  }
  EXPECT_FALSE(machine_.add_bookmark({0, kSteps + 1}, "late"));
}

TEST_F(PastOfARun, AnswersWhatWaitsAtItsEnd) {
  std::vector<std::future<ErrorCode>> answers;
  for (int i = 0; i < 200; ++i) {
    auto answer = std::make_shared<std::promise<ErrorCode>>();
    answers.push_back(answer->get_future());
    const auto step = static_cast<std::uint64_t>((i % 2) * 11'000 + i);
    machine_.ask({0, step}, [answer](const Result<api::PastMoment>& past) {
      answer->set_value(past ? ErrorCode::kNotFound : past.error().code);
    });
  }
  machine_.stop();
  int refused = 0;
  for (auto& answer : answers) refused += answer.get() == ErrorCode::kUnavailable;
  // No more than so many wait.
  EXPECT_GE(refused, 200 - 64 - 150);
  EXPECT_EQ(ask(machine_, {0, 5}).error().code, ErrorCode::kUnavailable);
}

TEST_F(PastOfARun, HasBookmarksInTheOrderOfTheirMoments) {
  bookmarks_.add({0, 3000}, api::BookmarkKind::kCommand, "fanuc: MoveTo");
  bookmarks_.add({7, 1}, api::BookmarkKind::kCommand, "of an epoch that is not kept");
  const auto own = machine_.add_bookmark({0, 2000}, "look here");
  ASSERT_TRUE(own);
  EXPECT_EQ(own->time, std::chrono::seconds(2));
  const auto all = machine_.bookmarks();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].text, "look here");
  EXPECT_EQ(all[1].kind, api::BookmarkKind::kCommand);
  EXPECT_EQ(machine_.add_bookmark({0, 1}, std::string(201, 'x')).error().field, "text");
  const auto revision = machine_.bookmark_revision();
  EXPECT_TRUE(machine_.remove_bookmark(own->id));
  EXPECT_GT(machine_.bookmark_revision(), revision);
  EXPECT_EQ(machine_.remove_bookmark(own->id).error().code, ErrorCode::kNotFound);
  for (std::size_t i = 0; i < api::kMaxOwnBookmarks; ++i) {
    ASSERT_TRUE(machine_.add_bookmark({0, i}, ""));
  }
  EXPECT_EQ(machine_.add_bookmark({0, 1}, "").error().code, ErrorCode::kFailedPrecondition);
}

}  // namespace
}  // namespace aprsim::world
