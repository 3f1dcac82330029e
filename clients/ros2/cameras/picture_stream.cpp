#include "clients/ros2/cameras/picture_stream.hpp"

#include <chrono>
#include <iostream>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "clients/wires/cell_connection.hpp"

namespace aprsim::ros2 {
namespace {

constexpr std::chrono::seconds kPictureRetry{1};

}  // namespace

PictureStream::PictureStream(client::Endpoints daemon, v1::StreamImagesRequest request, Take take)
    : daemon_(std::move(daemon)), request_(std::move(request)), take_(std::move(take)) {}

PictureStream::~PictureStream() { stop(); }

void PictureStream::update(bool wanted) {
  if (has_failed_) {
    stop();
    std::rethrow_exception(error_);
  }
  // A thread ends with its next picture, for which nobody waits here.
  if (is_over_ && thread_.joinable()) thread_.join();
  stopping_ = !wanted;
  if (!wanted || thread_.joinable()) return;
  is_over_ = false;
  thread_ = std::thread([this] { run(); });
}

void PictureStream::stop() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
}

void PictureStream::run() {
  std::string reported;
  while (!stopping_) {
    const auto done = stream();
    if (!done && done.error().message != reported) {
      reported = done.error().message;
      std::cerr << fmt::format("aprsim-ros2: camera {}: {}; trying again\n", request_.camera(),
                               reported);
    }
    client::sleep_until(std::chrono::steady_clock::now() + kPictureRetry,
                        [this] { return stopping_.load(); });
  }
  is_over_ = true;
}

client::Outcome<void> PictureStream::stream() {
  client::CellConnection connection(daemon_);
  return connection.images(request_, [this](const v1::StreamImagesResponse& response) {
    if (!stopping_) take(response.image());
    return !stopping_;
  });
}

void PictureStream::take(const v1::Image& image) {
  try {
    take_(image);
  } catch (const std::exception&) {
    error_ = std::current_exception();
    has_failed_ = true;
    stopping_ = true;
  }
}

}  // namespace aprsim::ros2
