// Viewers' requests to run programs, and the program status that viewers receive.
#include "tests/unit/protocols/web/web_fixture.hpp"

namespace aprsim {
namespace {

using test::RawWebClient;

/// Notes what it is asked; the test says what there is to tell.
class NotedPrograms final : public web::ProgramRunner {
 public:
  Result<void> start(const std::string& name, std::optional<std::uint64_t> seed) override {
    const std::lock_guard lock(mutex_);
    asked_.push_back("start " + name + (seed ? " " + std::to_string(*seed) : ""));
    if (name == "busy") return fail(ErrorCode::kFailedPrecondition, "name", "demo runs");
    return {};
  }
  Result<void> start_scenario(const std::string& name, const std::string& text,
                              std::optional<std::uint64_t> seed) override {
    const std::lock_guard lock(mutex_);
    asked_.push_back("scenario " + name + " " + text + (seed ? " " + std::to_string(*seed) : ""));
    return {};
  }
  Result<void> stop() override {
    const std::lock_guard lock(mutex_);
    asked_.emplace_back("stop");
    return {};
  }
  std::shared_ptr<const web::ProgramStatus> status() const override {
    const std::lock_guard lock(mutex_);
    return status_;
  }
  void tell(web::ProgramStatus status) {
    const std::lock_guard lock(mutex_);
    status_ = std::make_shared<const web::ProgramStatus>(std::move(status));
  }
  [[nodiscard]] std::vector<std::string> asked() const {
    const std::lock_guard lock(mutex_);
    return asked_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> asked_;
  std::shared_ptr<const web::ProgramStatus> status_ = std::make_shared<web::ProgramStatus>();
};

class ProgramRequest : public test::WebFixture {
 protected:
  ~ProgramRequest() override { server.reset(); }
  static v1::ViewerRequest start_of(const std::string& name) {
    v1::ViewerRequest request;
    request.mutable_start_program()->set_name(name);
    return request;
  }
  NotedPrograms programs;
};

TEST_F(ProgramRequest, StartsAndStops) {
  options.programs = &programs;
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  v1::ViewerRequest request = start_of("clean_2017");
  request.mutable_start_program()->set_seed(4);
  EXPECT_TRUE(client.ask(request).ok());
  EXPECT_TRUE(client.ask(start_of("demo")).ok());
  const auto refused = client.ask(start_of("busy"));
  EXPECT_EQ(refused.field(), "name");
  EXPECT_EQ(refused.message(), "demo runs");
  request.mutable_stop_program();
  EXPECT_TRUE(client.ask(request).ok());
  EXPECT_EQ(programs.asked(),
            (std::vector<std::string>{"start clean_2017 4", "start demo", "start busy", "stop"}));
  EXPECT_TRUE(world.commands().empty());
}

TEST_F(ProgramRequest, ProgressIsTold) {
  options.programs = &programs;
  programs.tell({.offers = {{"demo", "for ever", false}, {"clean_2017", "four kits", true}}});
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  const auto first = client.next([](const auto& u) { return u.has_programs(); });
  ASSERT_TRUE(first);
  ASSERT_EQ(first->programs().offers_size(), 2);
  EXPECT_EQ(first->programs().offers(1).description(), "four kits");
  EXPECT_TRUE(first->programs().offers(1).scenario());
  programs.tell({.name = "clean_2017",
                 .running = true,
                 .time_s = 3.5,
                 .placed = 4,
                 .orders = {{.name = "kits",
                             .tray = "kit",
                             .state = "open",
                             .kits = 2,
                             .done = 1,
                             .parts = 5,
                             .parts_wanted = 8}},
                 .lines = {"3.50 s: announced: kits"},
                 .report = "table"});
  const auto next = client.next([](const auto& u) { return u.has_programs(); });
  ASSERT_TRUE(next);
  const v1::ProgramStatus& status = next->programs();
  EXPECT_TRUE(status.running());
  EXPECT_EQ(status.time_s(), 3.5);
  EXPECT_EQ(status.placed(), 4U);
  ASSERT_EQ(status.orders_size(), 1);
  EXPECT_EQ(status.orders(0).name(), "kits");
  EXPECT_EQ(status.orders(0).parts(), 5U);
  EXPECT_EQ(status.orders(0).parts_wanted(), 8U);
  EXPECT_EQ(status.orders(0).done(), 1U);
  EXPECT_EQ(status.lines(0), "3.50 s: announced: kits");
  EXPECT_EQ(status.report(), "table");
}

TEST_F(ProgramRequest, NeedsPermission) {
  options.programs = &programs;
  options.control = false;
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  EXPECT_EQ(client.ask(start_of("demo")).field(), "permission");
  EXPECT_TRUE(programs.asked().empty());
}

TEST_F(ProgramRequest, WithoutProgramsThePageIsTold) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  const auto told = client.next([](const auto& u) { return u.has_programs(); });
  ASSERT_TRUE(told);
  EXPECT_EQ(told->programs().refusal(), "This daemon starts no programs (web.programs is false).");
  EXPECT_EQ(client.ask(start_of("demo")).message(), told->programs().refusal());
}

}  // namespace
}  // namespace aprsim
