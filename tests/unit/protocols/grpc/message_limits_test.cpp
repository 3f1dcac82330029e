// Bounds of what clients send over gRPC: messages, compression, uploads.

#include <atomic>
#include <vector>

#include "protocols/ports/state_files.hpp"
#include "tests/unit/protocols/grpc/telemetry_fixture.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;
using MessageLimits = TelemetryFixture;

/// Refuses all files, and counts them.
class NoFiles final : public protocols::StateFiles {
 public:
  [[nodiscard]] Result<std::string> write(const std::string&, const api::StatePtr&) override {
    return fail(ErrorCode::kUnavailable, "file", "none");
  }
  [[nodiscard]] Result<Read> read(std::string bytes) override {
    bytes_ = bytes.size();
    return fail(ErrorCode::kInvalidArgument, "file", "it is no state");
  }
  std::atomic<std::size_t> bytes_{0};
};

/// One upload that a test sends piece by piece.
struct Upload {
  explicit Upload(v1::ControlService::Stub& control) {
    context.set_deadline(std::chrono::system_clock::now() + 20s);
    writer = control.ImportState(&context, &response);
  }
  bool send(std::size_t bytes) {
    v1::ImportStateRequest request;
    request.set_data(std::string(bytes, 'x'));
    return writer->Write(request);
  }
  grpc::Status finish() {
    writer->WritesDone();
    return writer->Finish();
  }
  grpc::ClientContext context;
  v1::ImportStateResponse response;
  std::unique_ptr<grpc::ClientWriter<v1::ImportStateRequest>> writer;
};

TEST_F(MessageLimits, ASceneMayHaveAsManyBytesAsItsFile) {
  start();
  v1::ResetRequest request;
  v1::ResetResponse response;
  request.set_scene_text(std::string(1 << 20, '#'));
  grpc::ClientContext context;
  const grpc::Status status = control_->Reset(&context, request, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  request.set_scene_text(std::string(2 << 20, '#'));
  grpc::ClientContext larger;
  EXPECT_EQ(control_->Reset(&larger, request, &response).error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(cell_->commands().size(), 1U);
}

/// A small message that unpacks to more than the limit must not be unpacked at all.
TEST_F(MessageLimits, CompressedMessagesAreRefused) {
  start();
  for (const auto algorithm : {GRPC_COMPRESS_GZIP, GRPC_COMPRESS_DEFLATE}) {
    for (const std::size_t size : {std::size_t{1000}, std::size_t{60} << 20}) {
      v1::ResetRequest request;
      v1::ResetResponse response;
      request.set_scene_text(std::string(size, '#'));
      grpc::ClientContext context;
      context.set_compression_algorithm(algorithm);
      const grpc::Status status = control_->Reset(&context, request, &response);
      EXPECT_EQ(status.error_code(), grpc::StatusCode::UNIMPLEMENTED) << status.error_message();
    }
  }
  EXPECT_TRUE(cell_->commands().empty());
  v1::PauseResponse response;
  grpc::ClientContext context;
  EXPECT_TRUE(control_->Pause(&context, {}, &response).ok());
}

TEST_F(MessageLimits, UploadsAreBoundedEachAndTogether) {
  NoFiles files;
  grpc_server::TelemetryOptions options;
  options.state_files = &files;
  options.transfers = {.file_bytes = 100'000, .all_bytes = 150'000, .time = 20s};
  start(options);
  {
    Upload large(*control_);
    while (large.send(30'000)) {
    }
    const grpc::Status status = large.finish();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
    EXPECT_NE(status.error_message().find("more than 100000 bytes"), std::string::npos);
  }
  {
    Upload first(*control_), second(*control_);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(first.send(30'000));
    while (second.send(30'000)) {
    }
    // One of both has no room left; which one depends on the order of their messages.
    const grpc::Status statuses[] = {first.finish(), second.finish()};
    int together = 0;
    for (const grpc::Status& status : statuses) {
      if (status.error_message().find("all files on their way together") != std::string::npos ||
          status.error_message().find("more than 100000") != std::string::npos) {
        ++together;
      }
    }
    EXPECT_GE(together, 1);
  }
  // Their share of the limit is free again.
  Upload last(*control_);
  ASSERT_TRUE(last.send(30'000));
  EXPECT_EQ(last.finish().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(files.bytes_.load(), 30'000U);
}

/// Has one file of this size.
class OneFile final : public protocols::StateFiles {
 public:
  explicit OneFile(std::size_t bytes) : bytes_(bytes) {}
  [[nodiscard]] Result<std::string> write(const std::string&, const api::StatePtr&) override {
    return std::string(bytes_, 'x');
  }
  [[nodiscard]] Result<Read> read(std::string) override {
    return fail(ErrorCode::kUnavailable, "file", "none");
  }

 private:
  std::size_t bytes_;
};

/// One download; nothing is read before finish().
struct Download {
  explicit Download(v1::ControlService::Stub& control) {
    context.set_deadline(std::chrono::system_clock::now() + 20s);
    v1::ExportStateRequest request;
    request.set_name("saved");
    reader = control.ExportState(&context, request);
    reader->WaitForInitialMetadata();
  }
  grpc::Status finish() {
    v1::ExportStateResponse response;
    while (reader->Read(&response)) bytes += response.data().size();
    return reader->Finish();
  }
  grpc::ClientContext context;
  std::unique_ptr<grpc::ClientReader<v1::ExportStateResponse>> reader;
  std::size_t bytes = 0;
};

TEST_F(MessageLimits, DownloadsAreBoundedTogether) {
  constexpr std::size_t kBytes = 500'000;  // more than flow control sends at once
  OneFile files(kBytes);
  grpc_server::TelemetryOptions options;
  options.state_files = &files;
  options.transfers.all_bytes = 3 * kBytes / 2;
  start(options);
  // The state itself is never read.
  auto saved = std::make_shared<api::SavedStates>();
  saved->states.push_back({.name = "saved"});
  saved->states.back().state =
      api::StatePtr(std::shared_ptr<void>(), reinterpret_cast<const world::WorldState*>(&files));
  cell_->publish([&](api::Snapshot& now) { now.saved_states = saved; });
  Download first(*control_), second(*control_);
  const grpc::Status refused = second.finish();
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_NE(refused.error_message().find("all files on their way"), std::string::npos)
      << refused.error_message();
  EXPECT_TRUE(first.finish().ok());
  EXPECT_EQ(first.bytes, kBytes);
  // The share of a finished one is free again once its call has ended at the server.
  EXPECT_TRUE(eventually([&] { return Download(*control_).finish().ok(); }));
}

TEST_F(MessageLimits, AnUploadThatIsNotCompleteInTimeEnds) {
  NoFiles files;
  grpc_server::TelemetryOptions options;
  options.state_files = &files;
  options.transfers.time = 50ms;
  start(options);
  Upload silent(*control_), begun(*control_);
  ASSERT_TRUE(begun.send(10));
  for (Upload* upload : {&silent, &begun}) {
    const grpc::Status status = upload->writer->Finish();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
    EXPECT_NE(status.error_message().find("not complete within 50 ms"), std::string::npos)
        << status.error_message();
  }
  EXPECT_EQ(files.bytes_.load(), 0U);
}

}  // namespace
}  // namespace aprsim::test
