#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include "aprsim/v1/camera_service.pb.h"
#include "protocols/ports/camera_pictures.hpp"

namespace aprsim::grpc_server {

class ImageHub;

/// The pictures that a client requests.
struct ImageWish {
  std::size_t camera = 0;
  std::string name;  ///< of the camera
  v1::ImageFormat format = v1::IMAGE_FORMAT_RGB;
  protocols::PictureForm form = protocols::PictureForm::kRgb;
  double rate_hz = 10;
};

/// One client's stream of pictures, with at most one write in flight. While it sends, no picture is
/// taken for it: those due are counted as dropped, and one more is taken as soon as it has sent.
class ImageStream final : public grpc::ServerWriteReactor<grpc::ByteBuffer>,
                          public std::enable_shared_from_this<ImageStream> {
 public:
  ImageStream(grpc::CallbackServerContext& context, ImageHub& hub,
              protocols::CameraPictures& pictures, ImageWish wish);

  /// Sends the initial metadata. Call it first.
  void begin() { StartSendInitialMetadata(); }
  /// Takes the picture that is due. Thread: the hub's.
  void take();
  /// Cancels the call if one write has been in flight for longer than that. Thread: the hub's.
  void cancel_if_stuck(std::chrono::steady_clock::time_point now,
                       std::chrono::milliseconds write_timeout);
  /// Ends the call with the status, at once if no write is in flight, else by cancelling it.
  void end(const grpc::Status& status);
  /// Between two pictures.
  [[nodiscard]] std::chrono::nanoseconds period() const { return period_; }

  void OnSendInitialMetadataDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  /// Owned by the call: set right after construction, released in OnDone.
  std::shared_ptr<ImageStream> self;

 private:
  using Lock = std::unique_lock<std::mutex>;
  void take(Lock lock);
  void send(Result<protocols::CameraPicture> picture);
  void finish(const grpc::Status& status);

  grpc::CallbackServerContext& context_;
  ImageHub& hub_;
  protocols::CameraPictures& pictures_;
  const ImageWish wish_;
  const std::chrono::nanoseconds period_;
  grpc::ByteBuffer response_;  // touched only by whoever has set writing_

  std::mutex mutex_;
  bool writing_ = true;  // until the call has begun
  bool taking_ = false;  // a picture, which comes on another thread
  bool due_ = false;     // a picture as soon as it has sent
  bool finished_ = false, ending_ = false;
  grpc::Status end_status_;
  std::uint64_t sequence_ = 0, dropped_ = 0;
  std::chrono::steady_clock::time_point write_started_;
};

/// Has every stream take pictures at its own rate, by one thread and on the monotonic clock. Missed
/// ticks are skipped, not sent in a burst.
class ImageHub {
 public:
  ImageHub(int max_streams, std::chrono::milliseconds write_timeout);
  ~ImageHub();

  /// Not OK: RESOURCE_EXHAUSTED with too many streams, UNAVAILABLE once stopped.
  [[nodiscard]] grpc::Status add(const std::shared_ptr<ImageStream>& stream);
  void remove(const ImageStream& stream);
  /// Streams now. Thread: any.
  [[nodiscard]] std::size_t open();
  /// Ends every stream and the thread; returns when all streams are gone or at the deadline.
  void stop(std::chrono::steady_clock::time_point deadline);

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct Entry {
    std::shared_ptr<ImageStream> stream;
    Time due;
  };
  void run();
  [[nodiscard]] Time collect_due(Time now, std::vector<std::shared_ptr<ImageStream>>& due);

  const std::size_t max_streams_;
  const std::chrono::milliseconds write_timeout_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Entry> entries_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace aprsim::grpc_server
