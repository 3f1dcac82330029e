#include "protocols/grpc/streams/image_message.hpp"

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>

#include <google/protobuf/io/coded_stream.h>
#include <grpcpp/support/slice.h>

#include "protocols/messages/write_message.hpp"

namespace aprsim::grpc_server {
namespace {

/// Tag of a field that holds bytes or a message.
char tag_of(int field) { return static_cast<char>(field << 3 | 2); }

void append_length(std::string& to, std::size_t length) {
  std::array<std::uint8_t, 5> bytes{};
  const std::uint8_t* const end = google::protobuf::io::CodedOutputStream::WriteVarint32ToArray(
      static_cast<std::uint32_t>(length), bytes.data());
  to.append(bytes.begin(), bytes.begin() + (end - bytes.data()));
}

/// Shares the bytes, which live until gRPC has sent them.
grpc::Slice slice_of(const std::shared_ptr<const std::string>& bytes) {
  using Shared = std::shared_ptr<const std::string>;
  // gRPC takes a writable pointer and only reads.
  return {const_cast<char*>(bytes->data()), bytes->size(),
          [](void* shared) { delete static_cast<Shared*>(shared); }, new Shared(bytes)};
}

v1::Image image_of(const std::string& camera, v1::ImageFormat format,
                   const protocols::CameraPicture& picture) {
  v1::Image image;
  image.set_camera(camera);
  image.set_epoch(picture.epoch);
  image.set_step(picture.step);
  protocols::write_message(std::chrono::nanoseconds(picture.time), *image.mutable_sim_time());
  image.set_width_px(static_cast<std::uint32_t>(picture.width));
  image.set_height_px(static_cast<std::uint32_t>(picture.height));
  image.set_format(format);
  protocols::write_message(picture.X_WC, *image.mutable_camera_in_world());
  if (format == v1::IMAGE_FORMAT_SEGMENTATION && picture.objects) {
    for (const protocols::PictureObject& object : *picture.objects) {
      v1::ImageObject& out = *image.add_objects();
      out.set_kind(static_cast<v1::ImageObjectKind>(object.kind));
      out.set_name(object.name);
    }
  }
  return image;
}

}  // namespace

grpc::ByteBuffer image_message(const std::string& head, int field, const std::string& camera,
                               v1::ImageFormat format, const protocols::CameraPicture& picture) {
  std::string inner = image_of(camera, format, picture).SerializeAsString();
  inner += tag_of(v1::Image::kDataFieldNumber);
  append_length(inner, picture.bytes->size());
  std::string outer = head;
  outer += tag_of(field);
  append_length(outer, inner.size() + picture.bytes->size());
  const std::array<grpc::Slice, 2> slices{grpc::Slice(outer + inner), slice_of(picture.bytes)};
  return {slices.data(), slices.size()};
}

}  // namespace aprsim::grpc_server
