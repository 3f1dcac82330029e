#include "protocols/grpc/services/camera_service.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "protocols/grpc/calls/rpc_status.hpp"
#include "protocols/grpc/streams/image_message.hpp"
#include "protocols/messages/write_message.hpp"

namespace aprsim::grpc_server {
namespace {

using protocols::PictureForm;

constexpr int kMostTaken = 16;  // pictures for GetImage at once
constexpr double kMaxImageRate_hz = 60;
constexpr std::size_t kMostImageBytes = std::size_t{48} << 20U;

template <typename Message>
std::optional<Message> parse(const grpc::ByteBuffer& bytes) {
  Message message;
  grpc::ByteBuffer copy(bytes);  // of references; reading takes them
  if (!grpc::SerializationTraits<Message>::Deserialize(&copy, &message).ok()) return std::nullopt;
  return message;
}

Result<PictureForm> form_of(v1::ImageFormat format) {
  switch (format) {
    case v1::IMAGE_FORMAT_UNSPECIFIED:
    case v1::IMAGE_FORMAT_RGB:
      return PictureForm::kRgb;
    case v1::IMAGE_FORMAT_PNG:
      return PictureForm::kPng;
    case v1::IMAGE_FORMAT_JPEG:
      return PictureForm::kJpeg;
    case v1::IMAGE_FORMAT_DEPTH_FLOAT:
      return PictureForm::kDepth;
    case v1::IMAGE_FORMAT_DEPTH_16:
      return PictureForm::kDepth16;
    case v1::IMAGE_FORMAT_SEGMENTATION:
      return PictureForm::kSegments;
    case v1::IMAGE_FORMAT_NORMALS:
      return PictureForm::kNormals;
    default:
      return fail(ErrorCode::kInvalidArgument, "format",
                  fmt::format("{} is not a value of ImageFormat", static_cast<int>(format)));
  }
}

/// Bytes a pixel; of a compressed picture an upper estimate.
std::size_t bytes_a_pixel(PictureForm form) {
  switch (form) {
    case PictureForm::kNormals:
      return 12;
    case PictureForm::kDepth:
      return 4;
    case PictureForm::kDepth16:
    case PictureForm::kSegments:
      return 2;
    default:
      return 3;
  }
}

/// Refuses a stream before it begins.
class RefusedImages final : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  explicit RefusedImages(const grpc::Status& status) { Finish(status); }
  void OnDone() override { delete this; }
};

}  // namespace

CameraService::CameraService(protocols::CameraPictures* pictures, ImageHub& hub,
                             const CallGate& gate)
    : pictures_(pictures), hub_(hub), gate_(gate) {}

grpc::ServerUnaryReactor* CameraService::ListCameras(grpc::CallbackServerContext* context,
                                                     const v1::ListCamerasRequest* /*request*/,
                                                     v1::ListCamerasResponse* response) {
  auto* reactor = context->DefaultReactor();
  if (const auto refused = gate_.refusal(*context)) {
    reactor->Finish(*refused);
    return reactor;
  }
  if (pictures_ != nullptr) {
    const auto cameras = pictures_->cameras();
    for (const auto& camera : *cameras) {
      protocols::write_message(camera, *response->add_cameras());
    }
  }
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

Result<ImageWish> CameraService::wish(const std::string& name, v1::ImageFormat format,
                                      double rate_hz) const {
  const auto form = form_of(format);
  if (!form) return tl::unexpected(form.error());
  const auto cameras =
      pictures_ == nullptr ? std::make_shared<protocols::CameraList>() : pictures_->cameras();
  const auto found = std::ranges::find(*cameras, name, &api::CameraDescription::name);
  if (found == cameras->end()) {
    std::string names;
    for (const auto& camera : *cameras) names += (names.empty() ? "" : ", ") + camera.name;
    return fail(ErrorCode::kNotFound, "camera",
                fmt::format("no camera '{}'; there is {}", name, names.empty() ? "none" : names));
  }
  if (!std::isfinite(rate_hz) || rate_hz < 0 || rate_hz > kMaxImageRate_hz) {
    return fail(ErrorCode::kInvalidArgument, "rate_hz",
                fmt::format("{} is not within 0 and {} Hz", rate_hz, kMaxImageRate_hz));
  }
  const std::size_t bytes = std::size_t{found->width_px} * found->height_px * bytes_a_pixel(*form);
  if (bytes > kMostImageBytes) {
    return fail(ErrorCode::kFailedPrecondition, "format",
                fmt::format("a picture of {} in this format has {} MiB, more than {}", name,
                            bytes >> 20U, kMostImageBytes >> 20U));
  }
  // The lowest rate is one picture an hour; the period then fits its type.
  const double rate = rate_hz == 0 ? found->rate_hz : rate_hz;
  return ImageWish{name, format == v1::IMAGE_FORMAT_UNSPECIFIED ? v1::IMAGE_FORMAT_RGB : format,
                   *form, std::max(rate, 1.0 / 3600)};
}

grpc::ServerUnaryReactor* CameraService::GetImage(grpc::CallbackServerContext* context,
                                                  const grpc::ByteBuffer* bytes,
                                                  grpc::ByteBuffer* response) {
  auto* reactor = context->DefaultReactor();
  const auto refuse = [reactor](const grpc::Status& status) {
    reactor->Finish(status);
    return reactor;
  };
  if (const auto refused = gate_.refusal(*context)) return refuse(*refused);
  const auto request = parse<v1::GetImageRequest>(*bytes);
  if (!request) return refuse({grpc::StatusCode::INVALID_ARGUMENT, "it is not a GetImageRequest"});
  const auto wanted = wish(request->camera(), request->format(), 0);
  if (!wanted) return refuse(rpc_status(wanted.error()));
  if (++*taking_ > kMostTaken) {
    --*taking_;
    return refuse({grpc::StatusCode::RESOURCE_EXHAUSTED,
                   fmt::format("{} pictures are being taken; try again", kMostTaken)});
  }
  // The call exists until it is finished.
  pictures_->take_picture(wanted->camera, wanted->form,
                          [reactor, response, wanted = *wanted,
                           taking = taking_](const Result<protocols::CameraPicture>& picture) {
                            --*taking;
                            if (!picture) return reactor->Finish(rpc_status(picture.error()));
                            *response = image_message({}, v1::GetImageResponse::kImageFieldNumber,
                                                      wanted.camera, wanted.format, *picture);
                            reactor->Finish(grpc::Status::OK);
                          });
  return reactor;
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* CameraService::StreamImages(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* bytes) {
  if (const auto refused = gate_.refusal(*context)) return new RefusedImages(*refused);
  const auto request = parse<v1::StreamImagesRequest>(*bytes);
  if (!request) {
    return new RefusedImages(
        {grpc::StatusCode::INVALID_ARGUMENT, "it is not a StreamImagesRequest"});
  }
  auto wanted = wish(request->camera(), request->format(), request->rate_hz());
  if (!wanted) return new RefusedImages(rpc_status(wanted.error()));
  auto stream = std::make_shared<ImageStream>(*context, hub_, *pictures_, *std::move(wanted));
  stream->self = stream;
  if (const auto status = hub_.add(stream); !status.ok()) {
    stream->self.reset();
    return new RefusedImages(status);
  }
  stream->begin();
  return stream.get();
}

}  // namespace aprsim::grpc_server
