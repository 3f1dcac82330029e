#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "protocols/ports/camera_pictures.hpp"

namespace aprsim::test {

/// Cameras whose pictures are numbers as text, on threads as a studio has.
class NumberedPictures final : public protocols::CameraPictures {
 public:
  /// `bytes`: least size of each picture.
  explicit NumberedPictures(protocols::CameraList cameras, std::size_t bytes = 20)
      : cameras_(std::make_shared<const protocols::CameraList>(std::move(cameras))),
        bytes_(bytes) {}
  ~NumberedPictures() override { hold(false); }
  NumberedPictures(const NumberedPictures&) = delete;
  NumberedPictures& operator=(const NumberedPictures&) = delete;

  [[nodiscard]] std::shared_ptr<const protocols::CameraList> cameras() const override {
    return cameras_;
  }

  void take_picture(const std::string& camera, protocols::PictureForm form, Done done) override {
    const std::lock_guard lock(mutex_);
    last_form = form;
    threads_.emplace_back([this, camera, done = std::move(done), number = ++taken] {
      {
        std::unique_lock waiting(mutex_);
        released_.wait(waiting, [this] { return !held_; });
      }
      if (fails) {
        return done(fail(ErrorCode::kUnavailable, "camera", "the cell cannot be rendered"));
      }
      const auto text = std::make_shared<std::string>("picture " + std::to_string(number) + " ");
      text->resize(std::max(bytes_, text->size()), '.');
      const auto info = std::ranges::find(*cameras_, camera, &api::CameraDescription::name);
      if (info == cameras_->end()) return done(fail(ErrorCode::kNotFound, "camera", "none such"));
      done(protocols::CameraPicture{.epoch = 3,
                                    .step = number,
                                    .time = SimTime{number * 1'000'000},
                                    .width = static_cast<int>(info->width_px),
                                    .height = static_cast<int>(info->height_px),
                                    .X_WC = info->X_PC,
                                    .rate_hz = rate_hz > 0 ? rate_hz.load() : info->rate_hz,
                                    .latency_s = latency_s,
                                    .bytes = text,
                                    .objects = objects});
    });
  }

  /// While it holds, no picture comes.
  void hold(bool held) {
    const std::lock_guard lock(mutex_);
    held_ = held;
    released_.notify_all();
  }

  std::atomic<std::uint64_t> taken{0};
  std::atomic<bool> fails{false};
  std::atomic<double> rate_hz{0};  ///< that pictures state; 0 = the description's
  std::atomic<double> latency_s{0};
  std::atomic<protocols::PictureForm> last_form{};
  std::shared_ptr<const std::vector<protocols::PictureObject>> objects;

 private:
  const std::shared_ptr<const protocols::CameraList> cameras_;
  const std::size_t bytes_;
  std::mutex mutex_;
  std::condition_variable released_;
  bool held_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace aprsim::test
