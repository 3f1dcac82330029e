#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>
#include <zlib.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/trace/exports.hpp"
#include "clients/aprsim/trace/listing.hpp"
#include "clients/aprsim/trace/trace.hpp"
#include "proto/journal/frames.hpp"
#include "world/base/files/draft_file.hpp"
#include "world/base/utf8.hpp"

namespace aprsim::trace {
namespace {

namespace fs = std::filesystem;
using client::failed;
using client::FailureKind;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMostLines = 100'000;

std::string file_content(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Length-delimited messages of a motion file, one after the other.
Result<std::string> messages_of(const std::string& motion, std::uint64_t& count) {
  const std::string bytes = file_content(motion);
  auto frames = aprsim::journal::FrameDecoder::open(bytes);
  if (!frames) return tl::unexpected(frames.error());
  std::string out;
  for (std::string_view one = frames->next(); !one.empty(); one = frames->next()) {
    std::size_t left = one.size();
    for (; left >= 0x80; left >>= 7U) out += static_cast<char>(left | 0x80U);
    out += static_cast<char>(left);
    out += one;
    ++count;
  }
  if (!frames->damage().empty()) {
    return fail(ErrorCode::kInvalidArgument, "motion", motion + ": " + frames->damage());
  }
  return out;
}

/// Compresses with gzip, which every browser unpacks.
std::string gzip(const std::string& bytes) {
  z_stream stream{};
  constexpr int kGzip = 15 + 16, kMemory = 8;
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) !=
      Z_OK) {
    throw std::runtime_error("zlib: no memory");
  }
  std::string out;
  std::vector<unsigned char> piece(std::size_t{1} << 18);
  // zlib's interface lacks const.
  stream.next_in = reinterpret_cast<unsigned char*>(const_cast<char*>(bytes.data()));
  std::size_t left = bytes.size();
  int state = Z_OK;
  while (state != Z_STREAM_END) {
    if (stream.avail_in == 0 && left > 0) {
      stream.avail_in = static_cast<unsigned>(std::min<std::size_t>(left, 1U << 30U));
      left -= stream.avail_in;
    }
    stream.next_out = piece.data();
    stream.avail_out = static_cast<unsigned>(piece.size());
    state = deflate(&stream, left == 0 ? Z_FINISH : Z_NO_FLUSH);
    out.append(reinterpret_cast<char*>(piece.data()), piece.size() - stream.avail_out);
  }
  deflateEnd(&stream);
  return out;
}

std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) {
      return i + k < bytes.size() ? std::uint32_t{static_cast<std::uint8_t>(bytes[i + k])} : 0U;
    };
    const std::uint32_t three = byte(0) << 16U | byte(1) << 8U | byte(2);
    for (unsigned k = 0; k < 4; ++k) {
      out += i + k > bytes.size() ? '=' : kDigits[three >> (18U - 6U * k) & 63U];
    }
  }
  return out;
}

/// Escapes text that would end its script element.
std::string inside_script(std::string text) {
  for (std::size_t at = 0; (at = text.find("</", at)) != std::string::npos; at += 3) {
    text.replace(at, 2, "<\\/");
  }
  for (std::size_t at = 0; (at = text.find("<!--", at)) != std::string::npos; at += 5) {
    text.replace(at, 4, "<\\!--");
  }
  return text;
}

/// Escapes "<" in JSON.
std::string inside_json(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return out;
}

std::string inside_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  }
  return out;
}

v1::JournalHeader header_of_run(const std::string& place) {
  v1::JournalHeader header;
  static_cast<void>(for_each_record(place, [&](const v1::JournalRecord& record) {
    if (record.has_header()) header = record.header();
  }));
  return header;
}

}  // namespace

client::Outcome<Exported> export_html(const std::string& place, const std::string& motion,
                                      const std::string& file, const std::string& web) {
  if (motion.empty()) {
    return failed(FailureKind::kUsage, place + " has no scene and cannot be shown");
  }
  const std::string script = file_content((fs::path(web) / "player" / "player.js").string());
  const std::string style = file_content((fs::path(web) / "style.css").string());
  if (script.empty() || style.empty()) {
    return failed(FailureKind::kUsage, web + " has no page: this program was built without it");
  }
  Exported out;
  const auto messages = messages_of(motion, out.messages);
  if (!messages) return failed(FailureKind::kUsage, messages.error().message);
  out.snapshots = out.messages - 1;
  Json lines = Json::array();
  std::uint64_t left_out = 0;
  const auto listed = list_trace(place, {}, [&](const ListedLine& line) {
    if (lines.size() >= kMostLines) {
      ++left_out;
      return;
    }
    lines.push_back({{"time_s", line.time_s},
                     {"wire", line.wire},
                     {"direction", line.direction},
                     {"text", line.text}});
    ++(line.wire == "cell" ? out.events : out.wires);
  });
  if (!listed) return failed(FailureKind::kUsage, listed.error().message);
  std::vector<std::string> notes = *listed;
  if (left_out > 0) notes.push_back(fmt::format("{} more messages were left out", left_out));
  const v1::JournalHeader header = header_of_run(place);
  const std::string title =
      fmt::format("{}: {}", header.scene(), utf8::valid(fs::path(place).filename().string()));
  const Json about{
      {"title", title},
      {"facts", Json::array({Json::array({"Scene", header.scene()}),
                             Json::array({"Seed", std::to_string(header.seed())}),
                             Json::array({"Run", header.run_id()}),
                             Json::array({"Version", header.version()}),
                             Json::array({"Pictures", std::to_string(out.snapshots)})})},
      {"lines", lines},
      {"notes", notes}};
  files::DraftFile page(file);
  // The page requests nothing from outside.
  page.out()
      << "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src "
         "'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; media-src blob:; "
         "connect-src data: blob:\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>"
      << inside_text(title) << "</title>\n<style>\n"
      << style << "\n</style>\n</head>\n<body>\n<div id=\"app\"></div>\n"
      << "<script type=\"application/json\" id=\"about\">"
      << inside_json(about.dump(-1, ' ', false, Json::error_handler_t::replace)) << "</script>\n"
      << "<script type=\"text/plain\" id=\"motion\">" << base64(gzip(*messages)) << "</script>\n"
      << "<script>" << inside_script(script) << "</script>\n</body>\n</html>\n";
  if (auto done = page.commit(); !done) return failed(FailureKind::kUsage, done.error().message);
  return out;
}

}  // namespace aprsim::trace
