// Viewers' requests to edit scenarios: shipped texts, checks, and runs.
#include "tests/unit/protocols/web/web_fixture.hpp"

namespace aprsim {
namespace {

using test::RawWebClient;

/// Answers at once, by the text.
class AnsweredScenarios final : public web::ScenarioDrafts {
 public:
  Result<web::ScenarioSource> find(const std::string& name) override {
    if (name == "gone") return fail(ErrorCode::kNotFound, "name", "gone is not a scenario");
    return web::ScenarioSource{.text = "# " + name, .names = {"a", "b"}, .scene = "aprs"};
  }
  void check(std::string text, Answer answer) override {
    if (text == "slow") return;
    web::ScenarioCheck check{.kits = 2, .faults = 1, .time_limit_s = 60};
    if (text == "wrong") {
      check.problems = {{ErrorCode::kInvalidArgument, "orders", "scenario text:1:1: orders: no"}};
    }
    if (text == "elsewhere") check.run_refusal = "It is for another scene.";
    answer(check);
  }
};

class NotedRuns final : public web::ProgramRunner {
 public:
  Result<void> start(const std::string&, std::optional<std::uint64_t>) override { return {}; }
  Result<void> start_scenario(const std::string& name, const std::string& text,
                              std::optional<std::uint64_t> seed) override {
    const std::lock_guard lock(mutex_);
    runs_.push_back(name + ": " + text + (seed ? " " + std::to_string(*seed) : ""));
    return {};
  }
  Result<void> stop() override { return {}; }
  std::shared_ptr<const web::ProgramStatus> status() const override { return status_; }
  [[nodiscard]] std::vector<std::string> runs() const {
    const std::lock_guard lock(mutex_);
    return runs_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> runs_;
  std::shared_ptr<const web::ProgramStatus> status_ = std::make_shared<web::ProgramStatus>();
};

class ScenarioRequest : public test::WebFixture {
 protected:
  ~ScenarioRequest() override { server.reset(); }
  RawWebClient& connect() {
    options.scenarios = &scenarios;
    options.programs = &programs;
    start();
    client.emplace(port);
    (void)client->upgrade();
    return *client;
  }
  static v1::ViewerRequest check_of(const std::string& text, std::uint32_t id = 0) {
    v1::ViewerRequest request;
    request.set_id(id);
    request.mutable_check_scenario()->set_text(text);
    return request;
  }
  static v1::ViewerRequest run_of(const std::string& text, const std::string& name = "mine") {
    v1::ViewerRequest request;
    request.mutable_run_scenario()->set_text(text);
    request.mutable_run_scenario()->set_name(name);
    return request;
  }
  AnsweredScenarios scenarios;
  NotedRuns programs;
  std::optional<RawWebClient> client;
};

TEST_F(ScenarioRequest, GetsAShippedText) {
  connect();
  v1::ViewerRequest request;
  request.set_id(5);
  request.mutable_get_scenario()->set_name("a");
  client->send(request);
  const auto update = client->next([](const auto& u) { return u.has_scenario(); });
  ASSERT_TRUE(update);
  EXPECT_EQ(update->scenario().id(), 5U);
  EXPECT_EQ(update->scenario().text(), "# a");
  EXPECT_EQ(update->scenario().names_size(), 2);
  EXPECT_EQ(update->scenario().scene(), "aprs");
  request.mutable_get_scenario()->set_name("gone");
  EXPECT_EQ(client->ask(request).message(), "gone is not a scenario");
}

TEST_F(ScenarioRequest, IsCheckedWithoutARun) {
  connect().send(check_of("wrong", 6));
  auto update = client->next([](const auto& u) { return u.has_scenario_check(); });
  ASSERT_TRUE(update);
  EXPECT_EQ(update->scenario_check().id(), 6U);
  ASSERT_EQ(update->scenario_check().problems_size(), 1);
  EXPECT_EQ(update->scenario_check().problems(0).key(), "orders");
  EXPECT_EQ(update->scenario_check().problems(0).message(), "scenario text:1:1: orders: no");
  client->send(check_of("elsewhere", 7));
  update = client->next([](const auto& u) { return u.has_scenario_check(); });
  ASSERT_TRUE(update);
  EXPECT_EQ(update->scenario_check().run_refusal(), "It is for another scene.");
  EXPECT_EQ(update->scenario_check().kits(), 2U);
  EXPECT_EQ(update->scenario_check().faults(), 1U);
  EXPECT_EQ(update->scenario_check().time_limit_s(), 60);
  EXPECT_TRUE(programs.runs().empty());
}

TEST_F(ScenarioRequest, IsOneAtATime) {
  connect().send(check_of("slow"));
  EXPECT_EQ(client->ask(run_of("right")).message(), "the last check is still running");
}

TEST_F(ScenarioRequest, RunsAfterItsCheck) {
  auto request = run_of("right");
  request.mutable_run_scenario()->set_seed(4);
  EXPECT_TRUE(connect().ask(request).ok());
  EXPECT_EQ(programs.runs(), std::vector<std::string>{"mine: right 4"});
  EXPECT_EQ(client->ask(run_of("wrong")).message(), "scenario text:1:1: orders: no");
  EXPECT_EQ(client->ask(run_of("elsewhere")).message(), "It is for another scene.");
  EXPECT_EQ(programs.runs().size(), 1U);
}

TEST_F(ScenarioRequest, HasANameThatIsNoPath) {
  connect();
  for (const std::string& name :
       {std::string(), std::string("../x"), std::string("a/b"), std::string("-x"),
        std::string(".x"), std::string("a\0b", 3), std::string(65, 'a')}) {
    EXPECT_EQ(client->ask(run_of("right", name)).field(), "name") << name;
  }
  EXPECT_TRUE(programs.runs().empty());
}

TEST_F(ScenarioRequest, IsRefusedWhereNoneIsEditedOrRun) {
  options.scenarios = &scenarios;
  start();
  RawWebClient viewer(port);
  (void)viewer.upgrade();
  EXPECT_EQ(viewer.ask(run_of("right")).field(), "programs");
}

TEST_F(ScenarioRequest, IsRefusedInAReplay) {
  start();
  RawWebClient viewer(port);
  (void)viewer.upgrade();
  EXPECT_EQ(viewer.ask(check_of("right", 1)).field(), "scenario");
  v1::ViewerRequest request;
  request.mutable_get_scenario();
  EXPECT_EQ(viewer.ask(request).field(), "scenario");
}

}  // namespace
}  // namespace aprsim
