#pragma once

#include <atomic>
#include <memory>
#include <optional>

#include "aprsim/v1/camera_service.grpc.pb.h"
#include "protocols/grpc/calls/call_gate.hpp"
#include "protocols/grpc/streams/image_hub.hpp"
#include "protocols/ports/camera_pictures.hpp"

namespace aprsim::grpc_server {

/// aprsim.v1.CameraService on the callback API. Never waits. Pictures are sent as bytes, so that
/// all clients share them.
class CameraService final
    : public v1::CameraService::WithRawCallbackMethod_StreamImages<
          v1::CameraService::WithRawCallbackMethod_GetImage<
              v1::CameraService::WithCallbackMethod_ListCameras<v1::CameraService::Service>>> {
 public:
  /// `pictures` may be null: no cameras. All outlive the service.
  CameraService(protocols::CameraPictures* pictures, ImageHub& hub, const CallGate& gate);

  grpc::ServerUnaryReactor* ListCameras(grpc::CallbackServerContext* context,
                                        const v1::ListCamerasRequest* request,
                                        v1::ListCamerasResponse* response) override;
  grpc::ServerUnaryReactor* GetImage(grpc::CallbackServerContext* context,
                                     const grpc::ByteBuffer* request,
                                     grpc::ByteBuffer* response) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* StreamImages(
      grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) override;

 private:
  /// `rate_hz` 0 = the camera's.
  [[nodiscard]] Result<ImageWish> wish(const std::string& camera, v1::ImageFormat format,
                                       double rate_hz) const;

  protocols::CameraPictures* const pictures_;
  ImageHub& hub_;
  const CallGate& gate_;
  /// Pictures that are being taken for GetImage. A picture may come after the service has gone.
  const std::shared_ptr<std::atomic<int>> taking_ = std::make_shared<std::atomic<int>>(0);
};

}  // namespace aprsim::grpc_server
