#pragma once

#include <string>

#include <grpcpp/support/byte_buffer.h>

#include "aprsim/v1/camera_service.pb.h"
#include "protocols/ports/camera_pictures.hpp"

namespace aprsim::grpc_server {

/// A message with a picture as protobuf would write it, with the picture's bytes shared. `head`:
/// the message without its picture; `field`: number of the field that takes it, below 16.
[[nodiscard]] grpc::ByteBuffer image_message(const std::string& head, int field,
                                             const std::string& camera, v1::ImageFormat format,
                                             const protocols::CameraPicture& picture);

}  // namespace aprsim::grpc_server
