#include "protocols/web/http/http_session.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include <boost/asio/execution/outstanding_work.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/prefer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "protocols/access/call_roles.hpp"
#include "protocols/net/limited_log.hpp"
#include "protocols/web/http/beast_socket.hpp"
#include "protocols/web/http/content_negotiation.hpp"
#include "protocols/web/http/origin_check.hpp"
#include "protocols/web/http/request_target.hpp"
#include "world/base/rate_limit.hpp"

namespace aprsim::web {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using beast::error_code;

using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;
/// Response with an asset, which the table keeps.
using AssetResponse = http::response<http::span_body<const char>>;

constexpr std::uint32_t kMaxHeaderBytes = 8 * 1024;
constexpr auto kTimeout = std::chrono::seconds(20);
constexpr auto kFullTimeout = std::chrono::seconds(3);
constexpr auto kHandshakeTimeout = std::chrono::seconds(5);
constexpr auto kGoodbyeTimeout = std::chrono::seconds(2);

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

std::vector<std::string_view> values_of(const Request& request, http::field field) {
  std::vector<std::string_view> values;
  const auto [begin, end] = request.equal_range(field);
  for (auto line = begin; line != end; ++line) values.push_back(view(line->value()));
  return values;
}

/// All lines of one field as one list (RFC 9110, section 5.3).
std::string list_of(const Request& request, http::field field) {
  std::string list;
  for (const std::string_view value : values_of(request, field)) {
    if (!list.empty()) list += ", ";
    list += value;
  }
  return list;
}

/// Permits the daemon's own files and WebSocket only; no inline script or style.
std::string content_policy(const std::string& host) {
  const std::string sockets = host.empty() ? "" : " ws://" + host + " wss://" + host;
  return "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
         "manifest-src 'self'; connect-src 'self'" +
         sockets + "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
}

void set_security(http::fields& response) {
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Cross-Origin-Opener-Policy", "same-origin");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  // The browser revalidates each time; unchanged files are answered with 304.
  response.set(http::field::cache_control, "no-cache");
}

/// Simulated time covered by "/incident?last=SECONDS"; 60 s without a query.
Result<std::chrono::nanoseconds> incident_span(std::string_view query) {
  constexpr double kDefault_s = 60, kMax_s = 86'400;
  constexpr std::string_view kKey = "last=";
  double last_s = kDefault_s;
  if (!query.empty()) {
    const auto [end, error] = std::from_chars(query.data() + std::min(kKey.size(), query.size()),
                                              query.data() + query.size(), last_s);
    if (!query.starts_with(kKey) || error != std::errc() || end != query.data() + query.size() ||
        !(last_s > 0 && last_s <= kMax_s)) {
      return fail(ErrorCode::kInvalidArgument, "last",
                  "expected last=SECONDS, above 0 and up to 86400");
    }
  }
  return std::chrono::nanoseconds(std::llround(last_s * 1e9));
}

class Session final : public HttpSession, public std::enable_shared_from_this<Session> {
 public:
  using Slot = protocols::ConnectionLimiter::Slot;
  using Clock = std::chrono::steady_clock;

  Session(boost::asio::ip::tcp::socket socket, std::string peer, const HttpContext& context,
          std::shared_ptr<Slot> slot, std::function<void()> on_end)
      : stream_(boost::beast::tcp_stream(std::move(socket)),
                context.tls ? context.tls->context() : nullptr),
        peer_(std::move(peer)),
        context_(context),
        slot_(std::move(slot)),
        rate_(context.max_requests_per_s),
        on_end_(std::move(on_end)) {}

  ~Session() override {
    if (on_end_) on_end_();
  }

  void close() override { tcp().close(); }

  void start() {
    if (!stream_.is_secure()) return read();
    tcp().expires_after(kHandshakeTimeout);
    stream_.async_handshake(
        [self = shared_from_this()](const error_code& error) { self->on_handshake(error); });
  }

 private:
  [[nodiscard]] beast::tcp_stream& tcp() { return stream_.next_layer(); }

  void on_handshake(const error_code& error) {
    if (error) {
      const std::string why = context_.tls->failure(stream_.native_handle(), error.message());
      if (context_.refusals) context_.refusals->warn("closing " + peer_ + ": " + why);
      return tcp().close();
    }
    certificate_ = protocols::Tls::client_of(stream_.native_handle());
    read();
  }

  void read() {
    slot_->rest();
    parser_.emplace();
    parser_->header_limit(kMaxHeaderBytes);
    parser_->body_limit(0);
    tcp().expires_after(context_.full.empty() ? kTimeout : kFullTimeout);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](const error_code& error, std::size_t) {
                       self->on_read(error);
                     });
  }

  void on_read(const error_code& error) {
    asked_at_ = Clock::now();
    if (error == http::error::end_of_stream) return shut_down();
    if (error == http::error::header_limit) {
      return refuse(http::status::request_header_fields_too_large, "header too large", true);
    }
    if (error == http::error::body_limit || error == http::error::unexpected_body) {
      return refuse(http::status::payload_too_large, "requests must not have a body", true);
    }
    if (error.category() == http::make_error_code(http::error::bad_value).category()) {
      return refuse(http::status::bad_request, error.message(), true);
    }
    if (error) return;
    if (!rate_.admit(protocols::RateLimit::Clock::now())) {
      return refuse(http::status::too_many_requests, "too many requests", true);
    }
    slot_->used();
    handle(parser_->release());
  }

  void handle(Request request) {
    if (!context_.full.empty()) return reject();
    const auto target = read_target(view(request.target()), values_of(request, http::field::host),
                                    request.version());
    if (!target) return refuse(http::status::bad_request, target.error().message, true);
    // Browsers, which DNS rebinding needs, always send HTTP/1.1 with a host.
    if (!target->host.empty() && !is_own_host(target->host, context_.hosts)) {
      return refuse(http::status::misdirected_request,
                    "unknown host; add it to web.hosts in the configuration to allow it", true);
    }
    if (target->path == "/ws") return open_socket(std::move(request), target->host);
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
      return refuse(http::status::method_not_allowed, "only GET and HEAD are supported", true);
    }
    respond(request, *target);
  }

  void respond(const Request& request, const RequestTarget& target) {
    const auto live = context_.live.find(target.path);
    if (target.path == "/incident" || target.path == "/camera" || live != context_.live.end()) {
      if (const auto refusal = refusal_of(request, target.path)) return refuse_access(*refusal);
      if (target.path == "/camera") return take_picture(request, target.query);
      if (target.path == "/incident") return open_incident(request, target.query);
      return send_live(request, live->second());
    }
    const Asset* asset = context_.assets->find(target.path);
    if (!asset && context_.models) {
      models_ = context_.models();
      asset = models_->find(target.path);
    }
    if (!asset) return refuse(http::status::not_found, "no such file", !request.keep_alive());
    send_asset(request, *asset, target.host);
  }

  /// Caller of a request, identified by its bearer token or client certificate.
  protocols::Caller caller_of(const Request& request) {
    constexpr std::string_view kScheme = "Bearer ";
    protocols::Credentials credentials{.certificate = certificate_};
    const std::string_view value = view(request[http::field::authorization]);
    if (value.starts_with(kScheme)) credentials.token = value.substr(kScheme.size());
    return context_.access->identify(protocols::host_of(peer_), credentials);
  }

  std::optional<protocols::Refusal> refusal_of(const Request& request, std::string_view path) {
    const protocols::Role needed = protocols::role_needed(path);
    if (!context_.access || needed == protocols::Role::kNone) return std::nullopt;
    return context_.access->refusal(caller_of(request), path, needed);
  }

  void refuse_access(const protocols::Refusal& refusal) {
    using Kind = protocols::Refusal::Kind;
    if (context_.refusals) context_.refusals->warn(peer_ + " is refused: " + refusal.message);
    refuse(refusal.kind == Kind::kUnauthenticated ? http::status::unauthorized
           : refusal.kind == Kind::kPermission    ? http::status::forbidden
                                                  : http::status::too_many_requests,
           refusal.message, true);
  }

  void open_socket(Request request, const std::string& host) {
    if (!is_same_origin(view(request[http::field::origin]), host)) {
      spdlog::warn("web: refused {}: WebSocket opened by a page of another origin", peer_);
      return refuse(http::status::forbidden, "only pages of this daemon may open its WebSocket",
                    true);
    }
    auto slot = context_.take_viewer_slot();
    if (!slot) {
      return refuse(http::status::service_unavailable,
                    "The maximum number of viewers is connected.", true);
    }
    // The page sends a plain GET to learn why its WebSocket was refused; browsers hide the reason.
    if (!beast::websocket::is_upgrade(request)) {
      return refuse(http::status::upgrade_required, "this path needs a WebSocket upgrade", true);
    }
    protocols::Caller caller = caller_of(request);
    note_answer(http::status::switching_protocols);
    accept_web_socket(
        std::move(stream_), std::move(request),
        [&context = context_, peer = peer_, slot = slot_,
         caller = std::move(caller)](std::shared_ptr<WebSocket> socket) {
          slot->keep();
          slot->on_evict([viewer = std::weak_ptr<WebSocket>(socket)] {
            if (const auto open = viewer.lock()) open->drop();
          });
          context.on_viewer(std::move(socket), peer, caller);
        },
        [slot = std::move(slot), end = std::exchange(on_end_, nullptr)] {
          if (end) end();
        });
  }

  void send_asset(const Request& request, const Asset& asset, const std::string& host) {
    auto response = std::make_shared<AssetResponse>(http::status::ok, request.version());
    set_security(*response);
    response->set("Content-Security-Policy", content_policy(host));
    const bool packed =
        !asset.gzip.empty() && accepts_gzip(list_of(request, http::field::accept_encoding));
    const std::string& etag = packed ? asset.gzip_etag : asset.etag;
    response->set(http::field::etag, etag);
    response->set(http::field::content_type, asset.type);
    response->set(http::field::vary, "Accept-Encoding");
    response->keep_alive(request.keep_alive());
    if (matches_etag(list_of(request, http::field::if_none_match), etag)) {
      response->result(http::status::not_modified);
      return send(std::move(response));
    }
    if (packed) response->set(http::field::content_encoding, "gzip");
    const std::string& body = packed ? asset.gzip : asset.body;
    if (request.method() == http::verb::get) response->body() = {body.data(), body.size()};
    response->content_length(body.size());
    send(std::move(response));
  }

  void send_live(const Request& request, LivePage page) {
    auto response = std::make_shared<Response>(http::int_to_status(page.status), request.version());
    set_security(*response);
    response->set(http::field::content_type, page.type);
    response->keep_alive(request.keep_alive());
    response->content_length(page.body.size());
    if (request.method() == http::verb::get) response->body() = std::move(page.body);
    send(std::move(response));
  }

  /// Name of the camera of "/camera?name=NAME"; further parameters are ignored.
  [[nodiscard]] std::optional<std::string> camera_of(std::string_view query) const {
    constexpr std::string_view kKey = "name=";
    if (context_.cameras == nullptr || !query.starts_with(kKey)) return std::nullopt;
    return std::string(query.substr(kKey.size(), query.find('&') - kKey.size()));
  }

  void take_picture(const Request& request, std::string_view query) {
    const auto camera = camera_of(query);
    if (!camera) {
      return refuse(http::status::not_found, "no such camera; expected /camera?name=NAME",
                    !request.keep_alive());
    }
    // Another thread answers. Tracked work keeps the server's thread running until then.
    auto executor = boost::asio::prefer(stream_.get_executor(),
                                        boost::asio::execution::outstanding_work.tracked);
    const bool head = request.method() == http::verb::head, keep_alive = request.keep_alive();
    tcp().expires_never();
    context_.cameras->take_picture(
        *camera, protocols::PictureForm::kJpeg,
        [self = shared_from_this(), executor, head,
         keep_alive](Result<protocols::CameraPicture> picture) mutable {
          boost::asio::post(
              executor, [self = std::move(self), head, keep_alive, picture = std::move(picture)] {
                self->send_picture(picture, head, keep_alive);
              });
        });
  }

  void send_picture(const Result<protocols::CameraPicture>& picture, bool head, bool keep_alive) {
    if (!tcp().socket().is_open()) return;
    if (!picture) {
      return refuse(picture.error().code == ErrorCode::kNotFound
                        ? http::status::not_found
                        : http::status::service_unavailable,
                    picture.error().message, !keep_alive);
    }
    auto response = std::make_shared<Response>(http::status::ok, 11);
    set_security(*response);
    response->set(http::field::content_type, "image/jpeg");
    response->set("X-Step", std::to_string(picture->step));
    const auto& [p, q] = picture->X_WC;
    response->set("X-Pose", fmt::format("{} {} {} {} {} {} {}", p.x(), p.y(), p.z(), q.x(), q.y(),
                                        q.z(), q.w()));
    response->keep_alive(keep_alive);
    response->content_length(picture->bytes->size());
    if (!head) response->body() = *picture->bytes;
    send(std::move(response));
  }

  void open_incident(const Request& request, std::string_view query) {
    const auto last = incident_span(query);
    if (!last) return refuse(http::status::bad_request, last.error().message, false);
    if (context_.incidents == nullptr) {
      return refuse(http::status::not_found, "this daemon records no incidents", false);
    }
    // Another thread answers. Tracked work keeps the server's thread running until then.
    auto executor = boost::asio::prefer(stream_.get_executor(),
                                        boost::asio::execution::outstanding_work.tracked);
    const bool head = request.method() == http::verb::head, keep_alive = request.keep_alive();
    tcp().expires_never();
    context_.incidents->take_incident(
        *last, [self = shared_from_this(), executor, head,
                keep_alive](Result<protocols::Incident> incident) mutable {
          boost::asio::post(executor, [self = std::move(self), head, keep_alive,
                                       incident = std::move(incident)]() mutable {
            self->send_incident(std::move(incident), head, keep_alive);
          });
        });
  }

  void send_incident(Result<protocols::Incident> incident, bool head, bool keep_alive) {
    if (!tcp().socket().is_open()) return;
    if (!incident) {
      return refuse(http::status::service_unavailable, incident.error().message, !keep_alive);
    }
    auto response = std::make_shared<Response>(http::status::ok, 11);
    set_security(*response);
    response->set(http::field::content_type, "application/zstd");
    response->set(http::field::content_disposition,
                  "attachment; filename=\"" + incident->name + "\"");
    response->keep_alive(keep_alive);
    std::size_t size = 0;
    for (const auto& piece : incident->pieces) size += piece->size();
    response->content_length(size);
    note_answer(response->result());
    // The header is written first; the pieces follow as its body.
    auto serializer = std::make_shared<http::response_serializer<http::string_body>>(*response);
    auto pieces = std::make_shared<protocols::Incident>(*std::move(incident));
    if (head) pieces->pieces.clear();
    tcp().expires_after(kTimeout);
    http::async_write_header(stream_, *serializer,
                             [self = shared_from_this(), response, serializer, pieces](
                                 const error_code& error, std::size_t) {
                               if (!error) self->send_pieces(pieces, 0, response->need_eof());
                             });
  }

  /// Each piece has its own deadline, so a client that stops reading is disconnected.
  void send_pieces(const std::shared_ptr<protocols::Incident>& incident, std::size_t next,
                   bool last) {
    if (next == incident->pieces.size()) return last ? shut_down() : read();
    tcp().expires_after(kTimeout);
    boost::asio::async_write(
        stream_, boost::asio::buffer(*incident->pieces[next]),
        [self = shared_from_this(), incident, next, last](const error_code& error, std::size_t) {
          if (!error) self->send_pieces(incident, next + 1, last);
        });
  }

  /// Headers that RFC 9110 requires beside certain statuses.
  static void add_remedy(Response& response) {
    switch (response.result()) {
      case http::status::unauthorized:
        response.set(http::field::www_authenticate, "Bearer");
        break;
      case http::status::method_not_allowed:
        response.set(http::field::allow, "GET, HEAD");
        break;
      case http::status::upgrade_required:
        response.set(http::field::upgrade, "websocket");
        break;
      default:
        break;
    }
  }

  void refuse(http::status status, const std::string& why, bool last) {
    auto response = std::make_shared<Response>(status, 11);
    set_security(*response);
    response->set(http::field::content_type, "text/plain; charset=utf-8");
    add_remedy(*response);
    response->body() = why + "\n";
    response->keep_alive(!last);
    response->prepare_payload();
    send(std::move(response));
  }

  void reject() {
    auto response = std::make_shared<Response>(http::status::service_unavailable, 11);
    set_security(*response);
    response->set(http::field::content_type, "text/html; charset=utf-8");
    response->set(http::field::retry_after, "5");
    response->body() =
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\">"
        "<meta http-equiv=\"refresh\" content=\"5\"><title>aprsim: no room</title>"
        "<h1>aprsim</h1><p>" +
        context_.full + "</p></html>\n";
    response->keep_alive(false);
    response->prepare_payload();
    send(std::move(response));
  }

  void note_answer(http::status status) {
    ++context_.counts->requests;
    const bool ok = http::to_status_class(status) != http::status_class::client_error &&
                    http::to_status_class(status) != http::status_class::server_error;
    context_.counts->answered(Clock::now() - asked_at_, ok);
  }

  template <typename Body>
  void send(std::shared_ptr<http::response<Body>> response) {
    note_answer(response->result());
    const bool last = response->need_eof() || !response->keep_alive();
    const auto& message = *response;
    // Responses to HEAD and 304 carry a length but no body: write their header only.
    auto serializer = std::make_shared<http::response_serializer<Body>>(message);
    const auto done = [self = shared_from_this(), response = std::move(response), serializer, last](
                          const error_code& error, std::size_t) {
      if (error) return;
      if (last) return self->shut_down();
      self->read();
    };
    tcp().expires_after(kTimeout);
    if (message.body().empty()) {
      http::async_write_header(stream_, *serializer, done);
    } else {
      http::async_write(stream_, *serializer, done);
    }
  }

  void shut_down() {
    if (stream_.is_secure()) {
      tcp().expires_after(kGoodbyeTimeout);
      return stream_.async_shutdown([self = shared_from_this()](const error_code&) {});
    }
    error_code ignored;
    tcp().socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
  }

  WebStream stream_;
  std::shared_ptr<const protocols::ClientCertificate> certificate_;
  std::string peer_;
  const HttpContext& context_;
  std::shared_ptr<const AssetTable> models_;  // of the last response from it
  std::shared_ptr<Slot> slot_;
  protocols::RateLimit rate_;
  std::function<void()> on_end_;
  Clock::time_point asked_at_{};
  beast::flat_buffer buffer_{kMaxHeaderBytes + 4096};
  std::optional<http::request_parser<http::empty_body>> parser_;
};

}  // namespace

std::shared_ptr<HttpSession> serve_http(boost::asio::ip::tcp::socket socket, std::string peer,
                                        const HttpContext& context,
                                        std::shared_ptr<protocols::ConnectionLimiter::Slot> slot,
                                        std::function<void()> on_end) {
  const auto session = std::make_shared<Session>(std::move(socket), std::move(peer), context, slot,
                                                 std::move(on_end));
  slot->on_evict([weak = std::weak_ptr<Session>(session)] {
    if (const auto open = weak.lock()) open->close();
  });
  session->start();
  return session;
}

}  // namespace aprsim::web
