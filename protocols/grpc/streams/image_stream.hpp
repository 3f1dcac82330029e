#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>

#include "aprsim/v1/camera_service.pb.h"
#include "protocols/grpc/streams/bounded_stream.hpp"
#include "protocols/ports/camera_pictures.hpp"

namespace aprsim::grpc_server {

class ImageHub;

/// The pictures that a client requests.
struct ImageWish {
  std::string camera;
  v1::ImageFormat format = v1::IMAGE_FORMAT_RGB;
  protocols::PictureForm form = protocols::PictureForm::kRgb;
  double rate_hz = 10;
};

/// One client's stream of pictures, with at most one write in flight. While it sends, no picture is
/// taken for it: those due are counted as dropped, and one more is taken as soon as it has sent.
class ImageStream final : public BoundedStream<grpc::ByteBuffer>,
                          public std::enable_shared_from_this<ImageStream> {
 public:
  ImageStream(grpc::CallbackServerContext& context, ImageHub& hub,
              protocols::CameraPictures& pictures, ImageWish wish);

  /// Takes the picture that is due. Thread: the hub's.
  void take();
  /// Between two pictures.
  [[nodiscard]] std::chrono::nanoseconds period() const { return period_; }

  void OnDone() override;

  /// Owned by the call: set right after construction, released in OnDone.
  std::shared_ptr<ImageStream> self;

 private:
  void next(Lock lock) override;
  void take(Lock lock);
  void send(Result<protocols::CameraPicture> picture);

  ImageHub& hub_;
  protocols::CameraPictures& pictures_;
  const ImageWish wish_;
  const std::chrono::nanoseconds period_;
  grpc::ByteBuffer response_;  // touched only by whoever has begun a write
  bool taking_ = false;        // a picture, which comes on another thread
  bool due_ = false;           // a picture as soon as it has sent
  std::uint64_t sequence_ = 0, dropped_ = 0;
};

}  // namespace aprsim::grpc_server
