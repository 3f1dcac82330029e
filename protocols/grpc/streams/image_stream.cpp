#include "protocols/grpc/streams/image_stream.hpp"

#include <utility>

#include "protocols/grpc/calls/rpc_status.hpp"
#include "protocols/grpc/streams/image_hub.hpp"
#include "protocols/grpc/streams/image_message.hpp"

namespace aprsim::grpc_server {

ImageStream::ImageStream(grpc::CallbackServerContext& context, ImageHub& hub,
                         protocols::CameraPictures& pictures, ImageWish wish)
    : BoundedStream(context),
      hub_(hub),
      pictures_(pictures),
      wish_(std::move(wish)),
      period_(static_cast<std::int64_t>(1e9 / wish_.rate_hz)) {}

void ImageStream::take() { take(lock()); }

void ImageStream::take(Lock lock) {
  if (is_over() || taking_) return;
  if (is_writing()) {
    // Before the call has begun nothing is lost.
    if (!has_begun()) return;
    ++sequence_;
    ++dropped_;
    due_ = true;
    return;
  }
  taking_ = true;
  lock.unlock();
  pictures_.take_picture(wish_.camera, wish_.form,
                         [stream = shared_from_this()](Result<protocols::CameraPicture> picture) {
                           stream->send(std::move(picture));
                         });
}

void ImageStream::send(Result<protocols::CameraPicture> picture) {
  Lock held = lock();
  taking_ = false;
  if (is_over()) return;
  if (!picture) return finish(rpc_status(picture.error()));
  begin_write();
  v1::StreamImagesResponse head;
  head.set_sequence(++sequence_);
  head.set_dropped_count(dropped_);
  held.unlock();
  response_ = image_message(head.SerializeAsString(), v1::StreamImagesResponse::kImageFieldNumber,
                            wish_.camera, wish_.format, *picture);
  StartWrite(&response_);
}

void ImageStream::next(Lock lock) {
  if (std::exchange(due_, false)) take(std::move(lock));
}

void ImageStream::OnDone() {
  hub_.remove(*this);
  self.reset();
}

}  // namespace aprsim::grpc_server
