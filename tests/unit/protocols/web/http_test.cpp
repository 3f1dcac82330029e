#include "tests/support/eventually.hpp"
#include "tests/unit/protocols/web/web_fixture.hpp"

namespace aprsim {
namespace {

using test::RawWebClient;
using Http = test::WebFixture;

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(Http, ServesThePageWithItsSecurityHeaders) {
  start();
  RawWebClient client(port);
  const std::string answer = client.request("GET / HTTP/1.1");
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 200")) << answer;
  EXPECT_TRUE(has(answer, "<title>cell</title>"));
  EXPECT_TRUE(has(answer, "Content-Type: text/html"));
  EXPECT_TRUE(has(answer, "X-Content-Type-Options: nosniff"));
  const auto policy = answer.substr(answer.find("Content-Security-Policy: "));
  EXPECT_TRUE(has(policy, "default-src 'none'; script-src 'self'; style-src 'self'")) << policy;
  EXPECT_TRUE(has(policy, "connect-src 'self' ws://" + client.host())) << policy;
  EXPECT_FALSE(has(policy, "unsafe"));
}

TEST_F(Http, OneConnectionServesManyFiles) {
  start();
  RawWebClient client(port);
  EXPECT_TRUE(has(client.request("GET /app.js?v=1 HTTP/1.1"), "start();"));
  EXPECT_TRUE(has(client.request("GET /models/fanuc.urdf HTTP/1.1"), "<robot name=\"arm\"/>"));
  EXPECT_TRUE(has(client.request("GET /app.js HTTP/1.1", "Accept-Encoding: gzip, br\r\n"),
                  "Content-Encoding: gzip\r\n"));
}

TEST_F(Http, AnswersHeadAndUnchangedWithoutABody) {
  start();
  RawWebClient client(port);
  const std::string head = client.request("HEAD /app.js HTTP/1.1", "", false);
  EXPECT_TRUE(has(head, "Content-Length: 8")) << head;
  const auto at = head.find("ETag: ");
  ASSERT_NE(at, std::string::npos);
  const std::string etag = head.substr(at + 6, head.find("\r\n", at) - at - 6);
  const std::string again =
      client.request("GET /app.js HTTP/1.1", "If-None-Match: " + etag + "\r\n", false);
  EXPECT_TRUE(again.starts_with("HTTP/1.1 304")) << again;
  EXPECT_TRUE(has(client.request("GET / HTTP/1.1"), "cell"));
}

TEST_F(Http, NothingBesidesTheTableCanBeNamed) {
  start();
  for (const std::string path :
       {"/../secret.txt", "/..%2fsecret.txt", "/web/../../secret.txt", "//secret.txt", "/app.js/",
        "/app.js.gz", "/models/../secret.txt", "/%2e%2e/secret.txt", "/..\\secret.txt"}) {
    RawWebClient client(port);
    const std::string answer = client.request("GET " + path + " HTTP/1.1");
    EXPECT_TRUE(answer.starts_with("HTTP/1.1 40")) << path << "\n" << answer;
    EXPECT_FALSE(has(answer, "not yours")) << path;
  }
}

TEST_F(Http, TellsItsHealthAndWhyTheCellIsNotReady) {
  start();
  RawWebClient client(port);
  EXPECT_TRUE(has(client.request("GET /healthz HTTP/1.1"), "200"));
  EXPECT_TRUE(has(client.request("GET /readyz HTTP/1.1"), "\r\n\r\nready\n"));
  world.complain("the pace is 0.20 instead of 1");
  const std::string answer = client.request("GET /readyz?verbose HTTP/1.1");
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 503")) << answer;
  EXPECT_TRUE(answer.ends_with("the pace is 0.20 instead of 1\n")) << answer;
  EXPECT_TRUE(has(client.request("GET /healthz HTTP/1.1"), "200"));
  // Nobody has given this server metrics.
  EXPECT_TRUE(has(client.request("GET /metrics HTTP/1.1"), "404"));
}

TEST_F(Http, IsNotReadyWhileAnotherPartHasAProblem) {
  options.problem = [] { return std::string("crcl.scara: port 64444 is in use"); };
  start();
  RawWebClient client(port);
  const std::string answer = client.request("GET /readyz HTTP/1.1");
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 503")) << answer;
  EXPECT_TRUE(answer.ends_with("crcl.scara: port 64444 is in use\n")) << answer;
  // The simulation's own problem comes first.
  world.complain("the pace is 0.20 instead of 1");
  EXPECT_TRUE(client.request("GET /readyz HTTP/1.1").ends_with("the pace is 0.20 instead of 1\n"));
}

TEST_F(Http, MetricsAreMadeWhenTheyAreAskedFor) {
  int asked = 0;
  options.metrics = [&] { return "a " + std::to_string(++asked) + "\n"; };
  start();
  RawWebClient client(port);
  const std::string first = client.request("GET /metrics HTTP/1.1");
  EXPECT_TRUE(has(first, "Content-Type: text/plain; version=0.0.4")) << first;
  EXPECT_TRUE(first.ends_with("a 1\n")) << first;
  EXPECT_TRUE(client.request("GET /metrics HTTP/1.1").ends_with("a 2\n"));
}

TEST_F(Http, RefusesOtherMethodsBodiesAndLongHeaders) {
  start();
  EXPECT_TRUE(has(RawWebClient(port).request("DELETE / HTTP/1.1"), "405"));
  EXPECT_TRUE(has(RawWebClient(port).request("POST / HTTP/1.1", "Content-Length: 5\r\n"), "413"));
  const std::string longer = "X-Long: " + std::string(20'000, 'a') + "\r\n";
  EXPECT_TRUE(has(RawWebClient(port).request("GET / HTTP/1.1", longer), "431"));
  EXPECT_TRUE(has(RawWebClient(port).request("nonsense"), "400"));
}

TEST_F(Http, RefusesForeignHostsAndPages) {
  options.hosts = {"cell.example"};
  start();
  RawWebClient foreign(port);
  foreign.send("GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n");
  EXPECT_TRUE(has(foreign.answer(), "421"));
  RawWebClient known(port);
  known.send("GET / HTTP/1.1\r\nHost: cell.example:8080\r\n\r\n");
  EXPECT_TRUE(has(known.answer(), "200"));
  EXPECT_TRUE(has(RawWebClient(port).upgrade("http://evil.example"), "403"));
  RawWebClient own(port);
  EXPECT_TRUE(has(own.upgrade("http://" + own.host()), "101"));
}

/// First line of the answer to these bytes on a connection of its own.
std::string status_of(std::uint16_t port, const std::string& bytes) {
  RawWebClient client(port);
  client.send(bytes + "\r\n\r\n");
  const std::string answer = client.answer();
  return answer.substr(0, answer.find("\r\n"));
}

TEST_F(Http, AcceptsHttp10WithoutHostAndChecksAHostThatIsSent) {
  start();
  EXPECT_TRUE(has(status_of(port, "GET /healthz HTTP/1.0"), " 200 "));
  EXPECT_TRUE(has(status_of(port, "GET / HTTP/1.0"), " 200 "));
  EXPECT_TRUE(has(status_of(port, "GET /healthz HTTP/1.0\r\nHost: evil.example"), " 421 "));
  RawWebClient client(port);
  client.send("GET / HTTP/1.0\r\n\r\n");
  EXPECT_TRUE(has(client.answer(), "connect-src 'self'; base-uri"));
  EXPECT_TRUE(client.closed());
}

TEST_F(Http, RefusesMissingRepeatedAndMalformedHosts) {
  start();
  for (const std::string headers :
       {"", "\r\nHost: localhost\r\nHost: localhost", "\r\nHost: localhost\r\nHost: evil.example",
        "\r\nHost: localhost:80:90", "\r\nHost: a b", "\r\nHost: user@localhost"}) {
    EXPECT_TRUE(has(status_of(port, "GET /healthz HTTP/1.1" + headers), " 400 ")) << headers;
  }
  EXPECT_TRUE(has(status_of(port, "GET /healthz HTTP/1.1\r\nHost: localhost."), " 200 "));
  EXPECT_TRUE(has(status_of(port, "GET /healthz HTTP/1.1\r\nHost: LOCALHOST.:80"), " 200 "));
}

TEST_F(Http, AcceptsTargetsInAbsoluteForm) {
  start();
  const std::string host = "\r\nHost: localhost";
  EXPECT_TRUE(
      has(status_of(port, "GET http://127.0.0.1:80/readyz?verbose HTTP/1.1" + host), "200"));
  EXPECT_TRUE(has(status_of(port, "GET HTTP://localhost HTTP/1.1" + host), " 200 "));
  // The target's host counts, not that of the header.
  EXPECT_TRUE(has(status_of(port, "GET http://evil.example/ HTTP/1.1" + host), " 421 "));
  EXPECT_TRUE(has(status_of(port, "GET http://localhost/ HTTP/1.1\r\nHost: evil.example"), "200"));
  EXPECT_TRUE(has(status_of(port, "GET ftp://localhost/ HTTP/1.1" + host), " 404 "));
  EXPECT_TRUE(has(status_of(port, "GET http://me@localhost/ HTTP/1.1" + host), " 400 "));
}

TEST_F(Http, DecodesEscapedPathsOnce) {
  start();
  RawWebClient client(port);
  EXPECT_TRUE(has(client.request("GET /%61pp%2ejs HTTP/1.1"), " 200 "));
  EXPECT_TRUE(has(client.request("GET /healt%68z HTTP/1.1"), " 200 "));
  EXPECT_TRUE(has(client.request("GET /models%2Ffanuc.urdf HTTP/1.1"), " 404 "));
  EXPECT_TRUE(has(client.request("GET /%2561pp.js HTTP/1.1"), " 404 "));
  EXPECT_TRUE(has(client.request("GET /app.js%00 HTTP/1.1"), " 404 "));
  EXPECT_TRUE(has(client.request("GET /app.js%4 HTTP/1.1"), " 400 "));
}

TEST_F(Http, CompressesOnlyWhereTheClientAcceptsIt) {
  start();
  RawWebClient client(port);
  for (const std::string accepted : {"gzip", "br, GZIP;q=0.5", "*", "x-gzip"}) {
    EXPECT_TRUE(has(client.request("GET /app.js HTTP/1.1", "Accept-Encoding: " + accepted + "\r\n"),
                    "Content-Encoding: gzip"))
        << accepted;
  }
  for (const std::string refused :
       {"gzip;q=0", "gzip ; q=0.000, *", "br", "*;q=0", "gzip;q=none", "notgzip"}) {
    EXPECT_FALSE(has(client.request("GET /app.js HTTP/1.1", "Accept-Encoding: " + refused + "\r\n"),
                     "Content-Encoding"))
        << refused;
  }
  EXPECT_TRUE(has(
      client.request("GET /app.js HTTP/1.1", "Accept-Encoding: br\r\nAccept-Encoding: gzip\r\n"),
      "Content-Encoding: gzip"));
}

std::string etag_in(const std::string& answer) {
  const auto at = answer.find("ETag: ") + 6;
  return answer.substr(at, answer.find("\r\n", at) - at);
}

TEST_F(Http, ComparesEntityTagsWeaklyAndInLists) {
  start();
  RawWebClient client(port);
  const std::string plain = etag_in(client.request("GET /app.js HTTP/1.1"));
  const std::string gzip = "Accept-Encoding: gzip\r\n";
  const std::string packed = etag_in(client.request("GET /app.js HTTP/1.1", gzip));
  EXPECT_NE(plain, packed) << "different bytes need different strong tags";
  const auto get = [&](const std::string& headers, bool with_body) {
    return client.request("GET /app.js HTTP/1.1", headers, with_body);
  };
  for (const std::string& tags : {plain, "W/" + plain, "\"x,y\", " + plain, std::string("*")}) {
    EXPECT_TRUE(has(get("If-None-Match: " + tags + "\r\n", false), " 304 ")) << tags;
  }
  EXPECT_TRUE(has(get("If-None-Match: \"x\"\r\nIf-None-Match: W/" + plain + "\r\n", false), "304"));
  EXPECT_TRUE(has(get(gzip + "If-None-Match: W/" + packed + "\r\n", false), " 304 "));
  for (const std::string& tags :
       {packed, std::string("\"*\""), plain.substr(1), std::string("\"x")}) {
    EXPECT_TRUE(has(get("If-None-Match: " + tags + "\r\n", true), " 200 ")) << tags;
  }
}

TEST_F(Http, RefusalsNameTheRemedy) {
  start();
  EXPECT_TRUE(has(RawWebClient(port).request("DELETE / HTTP/1.1"), "Allow: GET, HEAD"));
  EXPECT_TRUE(has(RawWebClient(port).request("GET /ws HTTP/1.1"), "Upgrade: websocket"));
}

TEST_F(Http, EndsAConnectionThatAsksTooOften) {
  start();
  RawWebClient client(port);
  std::string flood;
  for (int i = 0; i < 2000; ++i) flood += "GET /none HTTP/1.1\r\nHost: localhost\r\n\r\n";
  client.send(flood);
  EXPECT_TRUE(client.closed());
}

TEST_F(Http, LimitsConnectionsAndViewers) {
  options.listener.limits.at_once = 3;
  options.max_viewers = 2;
  start();
  RawWebClient a(port), b(port), c(port);
  EXPECT_TRUE(has(a.upgrade(), "101"));
  EXPECT_TRUE(has(b.upgrade(), "101"));
  EXPECT_TRUE(has(c.upgrade(), "503"));
}

TEST_F(Http, IdleSessionsGiveWayToANewcomerViewersDoNot) {
  options.listener.limits.at_once = 2;
  start();
  RawWebClient viewer(port), idle(port);
  EXPECT_TRUE(has(viewer.upgrade(), "101"));
  EXPECT_TRUE(has(RawWebClient(port).request("GET / HTTP/1.1"), "200"));
  EXPECT_TRUE(idle.closed());
  v1::ViewerRequest watch;
  watch.mutable_watch();
  EXPECT_TRUE(viewer.ask(watch).ok());
}

TEST_F(Http, ConnectionsBetweenRequestsGiveWayToANewcomer) {
  options.listener.limits.at_once = 2;
  start();
  RawWebClient a(port), b(port);
  EXPECT_TRUE(has(a.request("GET / HTTP/1.1"), "200"));
  EXPECT_TRUE(has(b.request("GET / HTTP/1.1"), "200"));
  EXPECT_TRUE(has(a.request("GET / HTTP/1.1"), "200")) << "it stays open";
  RawWebClient late(port);
  EXPECT_TRUE(has(late.request("GET / HTTP/1.1"), "200"));
  EXPECT_TRUE(b.closed()) << "it has waited longest";
  EXPECT_TRUE(has(a.request("GET / HTTP/1.1"), "200"));
}

TEST_F(Http, TheViewerLimitHoldsForManyAtOnce) {
  options.listener.limits.at_once = 300;
  options.max_viewers = 24;
  start();
  std::vector<std::unique_ptr<RawWebClient>> clients;
  for (int i = 0; i < 200; ++i) {
    clients.push_back(std::make_unique<RawWebClient>(port));
    // Half a request: all are at the door before the first is through it.
    clients.back()->send("GET /ws HTTP/1.1\r\nHost: " + clients.back()->host() + "\r\n");
  }
  for (const auto& client : clients) {
    client->send(
        "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n");
  }
  int viewers = 0, refused = 0;
  for (const auto& client : clients) {
    const std::string answer = client->answer();
    viewers += answer.starts_with("HTTP/1.1 101");
    refused += answer.starts_with("HTTP/1.1 503") && has(answer, "maximum number of viewers");
  }
  EXPECT_EQ(viewers, 24);
  EXPECT_EQ(refused, 176);
  // The page asks why without an upgrade, and gets the same answer.
  EXPECT_TRUE(RawWebClient(port).request("GET /ws HTTP/1.1").starts_with("HTTP/1.1 503"));
  clients.clear();
  EXPECT_TRUE(
      test::eventually([&] { return has(RawWebClient(port).request("GET /ws HTTP/1.1"), "426"); }));
}

TEST_F(Http, AnswersBusyAtTheConnectionLimit) {
  options.listener.limits.at_once = 2;
  start();
  RawWebClient a(port), b(port);
  ASSERT_TRUE(has(a.upgrade(), "101"));
  ASSERT_TRUE(has(b.upgrade(), "101"));
  for (int i = 0; i < 100; ++i) {
    RawWebClient late(port);
    const std::string answer = late.request("GET / HTTP/1.1");
    ASSERT_TRUE(answer.starts_with("HTTP/1.1 503")) << answer;
    ASSERT_TRUE(has(answer, "All 2 connections for browsers are in use")) << answer;
    ASSERT_TRUE(late.closed());
  }
  EXPECT_TRUE(has(RawWebClient(port).upgrade(), "503"));
}

TEST_F(Http, ServesTheDocuments) {
  write("site/index.html", "<!doctype html><title>documents</title>");
  write("site/reference/metrics.html", "<!doctype html><title>metrics</title>");
  options.documents = directory() + "/site";
  start();
  EXPECT_TRUE(has(RawWebClient(port).request("GET /docs HTTP/1.1"), "url=/docs/"));
  EXPECT_TRUE(has(RawWebClient(port).request("GET /docs/ HTTP/1.1"), "<title>documents"));
  EXPECT_TRUE(has(RawWebClient(port).request("GET /docs/reference/metrics.html HTTP/1.1"),
                  "<title>metrics"));
  for (const char* path : {"/docs/secret.txt", "/docs/../secret.txt", "/docs/%2e%2e/secret.txt",
                           "/docs/reference", "/docs/reference/"}) {
    const std::string answer = RawWebClient(port).request(std::string("GET ") + path + " HTTP/1.1");
    EXPECT_TRUE(answer.starts_with("HTTP/1.1 404")) << path << "\n" << answer;
  }
}

TEST_F(Http, SaysHowToBuildMissingDocuments) {
  options.documents = "/nonexistent";
  start();
  const std::string answer = RawWebClient(port).request("GET /docs/ HTTP/1.1");
  EXPECT_TRUE(has(answer, "Run <code>docs/build</code>")) << answer;
}

TEST_F(Http, AMissingPageIsANotice) {
  options.assets = "/nonexistent";
  start();
  EXPECT_TRUE(has(RawWebClient(port).request("GET / HTTP/1.1"), "not built into this daemon"));
}

}  // namespace
}  // namespace aprsim
