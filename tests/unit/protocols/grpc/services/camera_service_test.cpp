#include <limits>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "aprsim/v1/camera_service.grpc.pb.h"
#include "tests/support/numbered_pictures.hpp"
#include "tests/unit/protocols/grpc/telemetry_fixture.hpp"

namespace aprsim::test {
namespace {

using protocols::PictureForm;
using namespace std::chrono_literals;

constexpr std::size_t kLargeBytes = std::size_t{8} << 20U;

/// A table's camera, and one with the largest picture that there can be.
protocols::CameraList two_cameras() {
  api::CameraDescription table{.name = "table", .robot = "fanuc", .width_px = 40, .height_px = 30};
  table.rate_hz = 50;
  table.latency_s = 0.25;
  table.X_PC.p = {1, 2, 3};
  table.focal_x_px = 100;
  table.focal_y_px = 101;
  table.centre_x_px = 19.5;
  table.centre_y_px = 14.5;
  table.distortion = {-0.1, 0.2, 0, 0, 0.3};
  return {table,
          {.name = "huge", .carrier = "fanuc", .width_px = 4096, .height_px = 4096, .rate_hz = 1}};
}

class CameraServiceTest : public TelemetryFixture {
 protected:
  ~CameraServiceTest() override { server_.reset(); }

  void begin(std::size_t bytes = 20, grpc_server::TelemetryOptions options = {}) {
    server_.reset();  // before the pictures that it uses
    pictures_.emplace(two_cameras(), bytes);
    options.cameras = &*pictures_;
    start(std::move(options));
    cameras_ = v1::CameraService::NewStub(channel_);
  }

  grpc::Status get(const std::string& camera, v1::ImageFormat format, v1::Image* image = nullptr) {
    grpc::ClientContext context;
    v1::GetImageRequest request;
    request.set_camera(camera);
    request.set_format(format);
    v1::GetImageResponse response;
    const grpc::Status status = cameras_->GetImage(&context, request, &response);
    if (image != nullptr) *image = response.image();
    return status;
  }

  using Reader = std::unique_ptr<grpc::ClientReader<v1::StreamImagesResponse>>;
  static Reader open(v1::CameraService::Stub& stub, grpc::ClientContext& context, double rate_hz) {
    v1::StreamImagesRequest request;
    request.set_camera("table");
    request.set_rate_hz(rate_hz);
    return stub.StreamImages(&context, request);
  }
  /// The end of a stream that is refused.
  grpc::Status end_of_stream(double rate_hz) {
    grpc::ClientContext context;
    const Reader reader = open(*cameras_, context, rate_hz);
    v1::StreamImagesResponse response;
    EXPECT_FALSE(reader->Read(&response));
    return reader->Finish();
  }

  /// A connection of its own for large messages.
  [[nodiscard]] std::shared_ptr<grpc::Channel> large_channel() const {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    arguments.SetMaxReceiveMessageSize(2 * static_cast<int>(kLargeBytes));
    return grpc::CreateCustomChannel("127.0.0.1:" + std::to_string(port_),
                                     grpc::InsecureChannelCredentials(), arguments);
  }

  std::optional<NumberedPictures> pictures_;
  std::unique_ptr<v1::CameraService::Stub> cameras_;
};

TEST_F(CameraServiceTest, ListsLensesAndPoses) {
  begin();
  grpc::ClientContext context;
  v1::ListCamerasResponse response;
  ASSERT_TRUE(cameras_->ListCameras(&context, {}, &response).ok());
  ASSERT_EQ(response.cameras_size(), 2);
  const v1::CameraDescription& table = response.cameras(0);
  EXPECT_EQ(table.name(), "table");
  EXPECT_EQ(table.robot(), "fanuc");
  EXPECT_EQ(table.width_px(), 40U);
  EXPECT_EQ(table.height_px(), 30U);
  EXPECT_EQ(table.rate_hz(), 50);
  EXPECT_EQ(table.latency_s(), 0.25);
  EXPECT_EQ(table.camera_in_world().position_m().z(), 3);
  EXPECT_EQ(table.focal_y_px(), 101);
  EXPECT_EQ(table.centre_x_px(), 19.5);
  ASSERT_EQ(table.distortion_size(), 5);
  EXPECT_EQ(table.distortion(4), 0.3);
  EXPECT_TRUE(table.carrier().empty());
  EXPECT_FALSE(table.has_camera_in_flange());
  EXPECT_EQ(response.cameras(1).carrier(), "fanuc");
  EXPECT_FALSE(response.cameras(1).has_camera_in_world());
  EXPECT_TRUE(response.cameras(1).has_camera_in_flange());
}

TEST_F(CameraServiceTest, GivesAPictureInEachFormat) {
  begin();
  pictures_->objects = std::make_shared<const std::vector<protocols::PictureObject>>(
      std::vector<protocols::PictureObject>{
          {}, {.kind = protocols::PictureObject::Kind::kIntruder, .name = "person"}});
  const std::vector<std::pair<v1::ImageFormat, PictureForm>> forms = {
      {v1::IMAGE_FORMAT_UNSPECIFIED, PictureForm::kRgb},
      {v1::IMAGE_FORMAT_RGB, PictureForm::kRgb},
      {v1::IMAGE_FORMAT_PNG, PictureForm::kPng},
      {v1::IMAGE_FORMAT_JPEG, PictureForm::kJpeg},
      {v1::IMAGE_FORMAT_DEPTH_FLOAT, PictureForm::kDepth},
      {v1::IMAGE_FORMAT_DEPTH_16, PictureForm::kDepth16},
      {v1::IMAGE_FORMAT_SEGMENTATION, PictureForm::kSegments},
      {v1::IMAGE_FORMAT_NORMALS, PictureForm::kNormals}};
  std::uint64_t number = 0;
  for (const auto& [format, form] : forms) {
    v1::Image image;
    ASSERT_TRUE(get("table", format, &image).ok());
    ++number;
    EXPECT_EQ(pictures_->last_form, form);
    EXPECT_EQ(image.camera(), "table");
    EXPECT_EQ(image.epoch(), 3U);
    EXPECT_EQ(image.step(), number);
    EXPECT_EQ(image.sim_time().nanos(), number * 1'000'000);
    EXPECT_EQ(image.width_px(), 40U);
    EXPECT_EQ(image.height_px(), 30U);
    EXPECT_EQ(image.camera_in_world().position_m().z(), 3);
    EXPECT_EQ(image.data(), "picture " + std::to_string(number) + " ..........");
    const bool segmented = format == v1::IMAGE_FORMAT_SEGMENTATION;
    ASSERT_EQ(image.objects_size(), segmented ? 2 : 0);
    if (!segmented) continue;
    EXPECT_EQ(image.objects(1).kind(), v1::IMAGE_OBJECT_KIND_INTRUDER);
    EXPECT_EQ(image.objects(1).name(), "person");
  }
}

TEST_F(CameraServiceTest, RefusesWhatItCannotGive) {
  begin();
  const grpc::Status unknown = get("none", v1::IMAGE_FORMAT_RGB);
  EXPECT_EQ(unknown.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(unknown.error_message(), "camera: no camera 'none'; there is table, huge");
  const grpc::Status format = get("table", static_cast<v1::ImageFormat>(77));
  EXPECT_EQ(format.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(format.error_message(), "format: 77 is not a value of ImageFormat");
  EXPECT_EQ(get("huge", v1::IMAGE_FORMAT_NORMALS).error_code(),
            grpc::StatusCode::FAILED_PRECONDITION);
  for (const double rate : {-1.0, 61.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(end_of_stream(rate).error_code(), grpc::StatusCode::INVALID_ARGUMENT) << rate;
  }
  EXPECT_EQ(pictures_->taken, 0U);
  pictures_->fails = true;
  EXPECT_EQ(get("table", v1::IMAGE_FORMAT_RGB).error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(end_of_stream(0).error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(CameraServiceTest, WithoutCamerasThereIsNone) {
  start();
  cameras_ = v1::CameraService::NewStub(channel_);
  EXPECT_EQ(get("table", v1::IMAGE_FORMAT_RGB).error_message(),
            "camera: no camera 'table'; there is none");
}

TEST_F(CameraServiceTest, StreamsNewPicturesInTheirOrder) {
  begin();
  grpc::ClientContext context;
  const Reader reader = open(*cameras_, context, 60);
  v1::StreamImagesResponse response;
  std::uint64_t step = 0;
  for (std::uint64_t i = 1; i <= 10; ++i) {
    ASSERT_TRUE(reader->Read(&response));
    EXPECT_EQ(response.sequence(), i + response.dropped_count());
    EXPECT_GT(response.image().step(), step);
    step = response.image().step();
  }
  context.TryCancel();
}

TEST_F(CameraServiceTest, ASlowReaderLosesPicturesAndGetsTheLatest) {
  begin(kLargeBytes);
  grpc::ClientContext slow_context, quick_context;
  const auto slow_stub = v1::CameraService::NewStub(large_channel());
  const auto quick_stub = v1::CameraService::NewStub(large_channel());
  const Reader slow = open(*slow_stub, slow_context, 60);
  v1::StreamImagesResponse response;
  ASSERT_TRUE(slow->Read(&response)) << slow->Finish().error_message();
  // While the other reads, the next one for this reader is stuck.
  const Reader quick = open(*quick_stub, quick_context, 60);
  std::uint64_t latest = 0;
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(quick->Read(&response));
    latest = response.image().step();
  }
  std::uint64_t sequence = 1, sent = 1, step = 0;
  while (response.dropped_count() == 0 || step <= latest) {
    ASSERT_TRUE(slow->Read(&response));
    ++sent;
    EXPECT_GT(response.sequence(), sequence);
    sequence = response.sequence();
    EXPECT_EQ(sequence, sent + response.dropped_count());
    step = response.image().step();
  }
  slow_context.TryCancel();
  quick_context.TryCancel();
}

TEST_F(CameraServiceTest, StreamsAndPicturesAtOnceAreLimited) {
  grpc_server::TelemetryOptions options;
  options.max_image_streams = 2;
  begin(20, options);
  grpc::ClientContext contexts[2];
  std::vector<Reader> readers;
  v1::StreamImagesResponse response;
  for (grpc::ClientContext& context : contexts) {
    readers.push_back(open(*cameras_, context, 1));
    ASSERT_TRUE(readers.back()->Read(&response));
  }
  EXPECT_EQ(end_of_stream(1).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  for (grpc::ClientContext& context : contexts) context.TryCancel();

  pictures_->hold(true);
  std::vector<std::jthread> clients;
  std::atomic<int> given = 0, refused = 0;
  for (int i = 0; i < 40; ++i) {
    clients.emplace_back([&] {
      const grpc::Status status = get("table", v1::IMAGE_FORMAT_RGB);
      given += status.ok() ? 1 : 0;
      refused += status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED ? 1 : 0;
    });
  }
  EXPECT_TRUE(eventually([&] { return refused == 24; }));
  pictures_->hold(false);
  clients.clear();
  EXPECT_EQ(given, 16);
  EXPECT_EQ(refused, 24);
}

TEST_F(CameraServiceTest, StoppingEndsStreamsAlsoWhileAPictureIsTaken) {
  begin();
  grpc::ClientContext context;
  const Reader reader = open(*cameras_, context, 60);
  v1::StreamImagesResponse response;
  ASSERT_TRUE(reader->Read(&response));
  const std::uint64_t taken = pictures_->taken;
  pictures_->hold(true);
  EXPECT_TRUE(eventually([&] { return pictures_->taken > taken; }));
  server_->stop();
  while (reader->Read(&response)) {
  }
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  pictures_->hold(false);
}

}  // namespace
}  // namespace aprsim::test
