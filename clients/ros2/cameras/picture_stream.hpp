#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <thread>

#include "aprsim/v1/camera_service.pb.h"
#include "clients/wires/endpoints.hpp"
#include "clients/wires/outcome.hpp"

namespace aprsim::ros2 {

/// Pictures of one camera of the daemon while they are wanted, in a thread of their own. A stream
/// that ends is reported once on standard error and tried again each second. Thread: one.
class PictureStream {
 public:
  /// Takes each picture. Thread: the stream's. An exception ends the pictures.
  using Take = std::function<void(const v1::Image&)>;

  PictureStream(client::Endpoints daemon, v1::StreamImagesRequest request, Take take);
  ~PictureStream();
  PictureStream(const PictureStream&) = delete;
  PictureStream& operator=(const PictureStream&) = delete;

  /// Begins or ends the pictures; to be called often. Throws the error that has ended them.
  void update(bool wanted);
  /// Ends the pictures and waits for the thread.
  void stop();

 private:
  void run();
  client::Outcome<void> stream();
  void take(const v1::Image& image);

  const client::Endpoints daemon_;
  const v1::StreamImagesRequest request_;
  const Take take_;
  std::atomic<bool> stopping_ = false;
  std::atomic<bool> is_over_ = false;  ///< the thread only has to be joined
  std::atomic<bool> has_failed_ = false;
  std::exception_ptr error_;  ///< of the thread; read once it has failed
  std::thread thread_;
};

}  // namespace aprsim::ros2
