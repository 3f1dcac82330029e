#include "world/render/exposure.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "world/base/simd/vec8f.hpp"
#include "world/base/simd/vector_clones.hpp"

namespace aprsim::render {
namespace {

constexpr int kSteps = 4096;
constexpr std::uint64_t kDirt = 0x64697274;  // sets its numbers apart from the noise's

/// sRGB codes (IEC 61966-2-1) of linear shares, with their fractions.
const std::array<float, kSteps + 1>& codes() {
  static const std::array<float, kSteps + 1> table = [] {
    std::array<float, kSteps + 1> out{};
    for (int i = 0; i <= kSteps; ++i) {
      const double x = static_cast<double>(i) / kSteps;
      const double s = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
      // In 1/256 of a code: the last bits of pow() differ between libraries.
      out[static_cast<std::size_t>(i)] = static_cast<float>(std::round(s * 255 * 256) / 256);
    }
    return out;
  }();
  return table;
}

std::uint8_t as_byte(float code) {
  return static_cast<std::uint8_t>(std::clamp(code + 0.5F, 0.0F, 255.0F));
}

const std::array<std::uint8_t, kSteps + 1>& rounded_codes() {
  static const std::array<std::uint8_t, kSteps + 1> table = [] {
    std::array<std::uint8_t, kSteps + 1> out{};
    std::transform(codes().begin(), codes().end(), out.begin(), as_byte);
    return out;
  }();
  return table;
}

/// Sums of a line's values and of those `step` after each, with their weights.
APRSIM_VECTOR_CLONES void weigh(const float* from, int step, const float* weights, int count,
                                Exposure::Line& out) {
  for (int i = 0; i < Exposure::kLineValues; i += kLanes) {
    Vec8f sum = broadcast(0.0F);
    for (int k = 0; k < count; ++k) sum += weights[k] * load(from + i + k * step);
    store(out.data() + i, sum);
  }
}

/// Places of the values in the tables of codes.
APRSIM_VECTOR_CLONES void to_steps(const Exposure::Line& light, float gain,
                                   std::array<int, Exposure::kLineValues>& out) {
  for (int i = 0; i < Exposure::kLineValues; i += kLanes) {
    const Vec8f share = clamp(gain * load(light.data() + i), 0, 1);
    const Vec8i steps = truncate(share * kSteps + 0.5F);
    std::memcpy(out.data() + i, &steps, sizeof steps);
  }
}

/// Steele et al. 2014, splitmix64.
std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

/// Nearly normal, standard deviation 1: the sum of four uniform numbers of 5 bits.
float normal(std::uint32_t bits) {
  constexpr float kMean = 62, kDeviation = 18.466185F;
  const auto sum =
      (bits & 31U) + ((bits >> 5U) & 31U) + ((bits >> 10U) & 31U) + ((bits >> 15U) & 31U);
  return (static_cast<float>(sum) - kMean) / kDeviation;
}

/// Uniform in [0, 1), number `i` of a sequence.
float uniform(std::uint64_t sequence, std::uint64_t i) {
  return static_cast<float>(mix(sequence + i) >> 40U) * 0x1p-24F;
}

/// Share of the brightness that a flicker leaves. It begins at its brightest.
float left_by(const scene::Flicker& flicker, double time_s) {
  const double turns = flicker.rate_hz * time_s;
  const double swing = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (turns - std::floor(turns)));
  // In steps: the last bits of cos() differ between libraries.
  return static_cast<float>(std::round((1 - flicker.share * swing) * kSteps) / kSteps);
}

}  // namespace

Exposure::Exposure(const scene::Camera& camera, std::uint64_t seed)
    : width_(camera.lens.width_px),
      height_(camera.lens.height_px),
      exposure_(static_cast<float>(camera.exposure)),
      seed_(mix(seed)) {
  set_flaws(camera, 0);
  constexpr double kLeastBlur_px = 0.2, kDeviations = 2.5;
  kernel_[0] = 1;
  if (camera.blur_px < kLeastBlur_px) return;
  reach_ = std::min(kMaxReach, static_cast<int>(std::ceil(kDeviations * camera.blur_px)));
  std::vector<double> weights;
  double sum = 0;
  for (int i = -reach_; i <= reach_; ++i) {
    weights.push_back(std::exp(-0.5 * i * i / (camera.blur_px * camera.blur_px)));
    sum += weights.back();
  }
  for (std::size_t i = 0; i < weights.size(); ++i) {
    kernel_[i] = static_cast<float>(weights[i] / sum);
  }
}

bool Exposure::set_flaws(const scene::Camera& camera, double time_s) {
  float gain = exposure_;
  for (const scene::Flicker& flicker : camera.flicker) gain *= left_by(flicker, time_s);
  const auto noise = static_cast<float>(camera.noise);
  const bool changed = gain != gain_ || noise != noise_ || camera.dirt != dirt_;
  gain_ = gain;
  noise_ = noise;
  if (camera.dirt != dirt_) {
    dirt_ = camera.dirt;
    spread_dirt();
  }
  return changed;
}

/// A spot takes most in its middle, and nothing from its rim on: it is out of focus.
void Exposure::spread_dirt() {
  passing_.clear();
  if (dirt_.empty()) return;
  const auto width = static_cast<float>(width_), height = static_cast<float>(height_);
  std::vector<std::array<float, 4>> spots;  // x, y, radius, share
  for (const scene::LensDirt& dirt : dirt_) {
    const std::uint64_t sequence = mix(seed_ ^ mix(dirt.pattern ^ kDirt));
    for (int i = 0; i < dirt.spots; ++i) {
      const auto at = static_cast<std::uint64_t>(3 * i);
      spots.push_back({width * uniform(sequence, at), height * uniform(sequence, at + 1),
                       static_cast<float>(dirt.size) * width * (0.5F + uniform(sequence, at + 2)),
                       static_cast<float>(dirt.share)});
    }
  }
  passing_.reserve(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      float passing = 255;
      for (const auto& [spot_x, spot_y, radius, share] : spots) {
        const float dx = static_cast<float>(x) - spot_x, dy = static_cast<float>(y) - spot_y;
        const float inside = std::max(0.0F, 1 - (dx * dx + dy * dy) / (radius * radius));
        passing *= 1 - share * inside * inside;
      }
      passing_.push_back(static_cast<std::uint8_t>(passing + 0.5F));
    }
  }
}

float Exposure::passing(int x, int y) const {
  if (passing_.empty()) return 1;
  return static_cast<float>(
             passing_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                      static_cast<std::size_t>(x)]) /
         255;
}

void Exposure::encode(const Line& light, int x0, int y, int pixels, std::uint64_t frame,
                      std::uint8_t* out) const {
  Line gained = light;
  if (!passing_.empty()) {
    for (int i = 0; i < kChannels * pixels; ++i) {
      gained[static_cast<std::size_t>(i)] *= passing(x0 + i / kChannels, y);
    }
  }
  std::array<int, kLineValues> steps;
  to_steps(gained, gain_, steps);
  const int values = kChannels * pixels;
  if (!(noise_ > 0)) {
    for (int i = 0; i < values; ++i) {
      out[i] = rounded_codes()[static_cast<std::size_t>(steps[static_cast<std::size_t>(i)])];
    }
    return;
  }
  const std::uint64_t sequence = seed_ ^ mix(frame);
  for (int i = 0; i < pixels; ++i) {
    const std::uint64_t pixel =
        static_cast<std::uint64_t>(y) << 20U | static_cast<std::uint64_t>(x0 + i);
    const std::uint64_t bits = mix(sequence ^ (pixel * 0x9e3779b97f4a7c15U));
    for (int c = 0; c < kChannels; ++c) {
      const auto k = static_cast<std::size_t>(kChannels * i + c);
      const float code =
          codes()[static_cast<std::size_t>(steps[k])] +
          noise_ * normal(static_cast<std::uint32_t>(bits >> (20U * static_cast<unsigned>(c))));
      out[k] = as_byte(code);
    }
  }
}

/// Values of the pixels of one row from x on; those beyond its ends are those at the ends.
void Exposure::copy_row(const Picture<float>& light, int x, int y, int pixels, float* to) const {
  const int inside = std::clamp(light.width - x, 0, pixels);
  const int before = std::clamp(-x, 0, pixels);
  for (int i = 0; i < before; ++i) std::copy_n(light.at(0, y), kChannels, to + kChannels * i);
  if (inside > before) {
    std::copy_n(light.at(x + before, y), kChannels * (inside - before), to + kChannels * before);
  }
  for (int i = inside; i < pixels; ++i) {
    std::copy_n(light.at(light.width - 1, y), kChannels, to + kChannels * i);
  }
}

void Exposure::expose(const Picture<float>& light, int column, int row, std::uint64_t frame,
                      Picture<std::uint8_t>& out) const {
  const int x0 = column * TileGrid::kWidth, y0 = row * TileGrid::kHeight;
  const int pixels = std::min(TileGrid::kWidth, out.width - x0);
  const int rows = std::min(TileGrid::kHeight, out.height - y0);
  // Along the rows, then down the columns.
  constexpr int kBeyond = 2 * kMaxReach;
  std::array<Line, TileGrid::kHeight + kBeyond> along;
  alignas(32) std::array<float, kLineValues + kChannels * kBeyond> source;
  for (int i = 0; i < rows + 2 * reach_; ++i) {
    const int y = std::clamp(y0 + i - reach_, 0, out.height - 1);
    copy_row(light, x0 - reach_, y, TileGrid::kWidth + 2 * reach_, source.data());
    weigh(source.data(), kChannels, kernel_.data(), 2 * reach_ + 1,
          along[static_cast<std::size_t>(i)]);
  }
  for (int i = 0; i < rows; ++i) {
    Line line;
    weigh(along[static_cast<std::size_t>(i)].data(), kLineValues, kernel_.data(), 2 * reach_ + 1,
          line);
    encode(line, x0, y0 + i, pixels, frame, out.at(x0, y0 + i));
  }
}

}  // namespace aprsim::render
