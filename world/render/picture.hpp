#pragma once

#include <cstdint>
#include <vector>

namespace aprsim::render {

/// Values of all pixels, row by row from the top left; `channels` a pixel.
template <typename T>
struct Picture {
  int width = 0, height = 0, channels = 1;
  std::vector<T> values;

  Picture() = default;
  Picture(int w, int h, int c)
      : width(w),
        height(h),
        channels(c),
        values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) *
               static_cast<std::size_t>(c)) {}
  [[nodiscard]] T* at(int x, int y) { return values.data() + index(x, y); }
  [[nodiscard]] const T* at(int x, int y) const { return values.data() + index(x, y); }

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
            static_cast<std::size_t>(x)) *
           static_cast<std::size_t>(channels);
  }
};

}  // namespace aprsim::render
