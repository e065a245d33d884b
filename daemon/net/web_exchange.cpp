#include "daemon/net/web_exchange.h"

#include <asio/co_spawn.hpp>

#include "daemon/net/web_scenes.h"
#include "daemon/web/qr_page.h"
#include "daemon/web/upgrade.h"

namespace gnomon::daemon {
namespace {

constexpr const char* kSession = "/session";

ReachedAt reached_at(const asio::ip::tcp::endpoint& local) {
  asio::ip::address address = local.address();
  if (address.is_v6() && address.to_v6().is_v4_mapped()) {
    address = asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
  }
  return {address.to_string(), local.port(), true};
}

// For the policy of a page on this host. Which UDP port its session has depends on the net thread that it comes to.
std::string data_ports_at(const std::string& host) {
  const size_t colon = host.rfind(':');
  const bool has_port = colon != std::string::npos && host.find(']', colon) == std::string::npos;
  return host.empty() ? "" : "https://" + host.substr(0, has_port ? colon : host.size()) + ":*";
}

// The names of the certificate and those of the configuration.
std::vector<std::string> names_of(const NetShared& shared) {
  std::vector<std::string> names = (*shared.tls.get())->names;
  names.insert(names.end(), shared.web->hosts.begin(), shared.web->hosts.end());
  return names;
}

}  // namespace

WebExchange::WebExchange(const NetShared& shared, asio::io_context& io, PendingConnections& pending,
                         ControlStream& stream, TokenBuckets<ClientNetwork>& requests)
    : shared_(shared),
      io_(io),
      pending_(pending),
      stream_(stream),
      requests_(requests),
      hosts_(names_of(shared)),
      progress_(shared.web->patience, Clock::now()) {}

void WebExchange::on_open() {
  progress_.asks(Clock::now());
  set_deadline();
}

// Requests that come before the last one is answered wait, a header's length of them.
void WebExchange::on_bytes(std::span<const uint8_t> bytes) {
  reader_.feed(bytes);
  if (!answering_) return answer_requests();
  if (reader_.size() > web::RequestReader::kMaxHeader)
    stream_.end_later("more requests than it waits for answers to");
}

void WebExchange::on_sent(size_t bytes) {
  const TimePoint now = Clock::now();
  progress_.sent(bytes, now);
  if (answering_ && stream_.has_sent_all()) {
    if (leaving_) return leave();
    answering_ = false;
    progress_.asks(now);
  }
  set_deadline();
  if (!answering_) answer_requests();
}

void WebExchange::answer_requests() {
  while (!answering_ && stream_.is_open()) {
    auto read = reader_.next();
    if (const auto* bad = std::get_if<web::BadRequest>(&read)) {
      web::Response response = web::text_response(bad->status, bad->why);
      response.close = true;
      return respond({}, response);
    }
    const auto& request = std::get<std::optional<web::Request>>(read);
    if (!request) return;
    answer(*request);
  }
}

// Of a file of the page's, which is ready to be sent. A code has to be drawn, and a list to be written.
double WebExchange::cost_of(const web::Request& request) const {
  constexpr double kOfACode = 20, kOfAHundredNames = 1;
  if (web::qr_target(request.target)) return kOfACode;
  const auto scene = web::scene_target(request.target);
  if (!scene || !scene->name.empty()) return 1;
  return 1 + kOfAHundredNames * static_cast<double>(shared_.catalog.get()->sources().size()) / 100;
}

void WebExchange::answer(const web::Request& request) {
  if (!requests_.take(network_of(stream_.peer()), cost_of(request), Clock::now())) {
    shared_.metrics.report(Fault::web_rate, {{"address", stream_.peer().to_string()}});
    web::Response response = web::text_response(429, "too many requests from this address");
    response.fields.emplace_back("Retry-After", "1");
    response.close = true;  // further connections have a rate too
    return respond(request, response);
  }
  const auto response = response_to(request);
  if (!response) return answer_later(request, *web::scene_target(request.target));
  respond(request, *response);
  if (response->status != 101) return;
  // As long to say Hello as a client that came without HTTP.
  pending_.set_deadline(&stream_, Clock::now() + shared_.config.server.handshake_timeout);
  const std::vector<uint8_t> rest = reader_.take_rest();
  stream_.become_websocket(rest, request.origin);  // the exchange may be gone afterwards
}

// The scene may have to be read first, and its pack to be made.
void WebExchange::answer_later(const web::Request& request, const web::SceneTarget& target) {
  answering_ = true;
  progress_.waits();
  set_deadline();
  const auto stream = std::static_pointer_cast<ControlStream>(stream_.shared_from_this());
  const auto self = shared_from_this();
  asio::co_spawn(io_, await_scene(stream, request, target), [self, stream](const std::exception_ptr&) {});
}

asio::awaitable<void> WebExchange::await_scene(std::shared_ptr<ControlStream> stream, web::Request request,
                                               web::SceneTarget target) {
  std::optional<web::Response> response;
  bool enough_memory = true;
  try {
    response = co_await answer_about_scene(shared_, io_, stream, request, target, departure_.get_token());
  } catch (const std::bad_alloc&) {
    enough_memory = false;
  }
  if (departure_.stop_requested()) co_return;
  if (!enough_memory) response = web::text_response(503, "the server has no memory for it");
  respond(request, *response);
}

std::optional<web::Response> WebExchange::response_to(const web::Request& request) const {
  if (!hosts_.allows_host(request.host, reached_at(stream_.reached()))) {
    return web::text_response(403, "this server does not go by the name in Host; web.hosts lists further ones");
  }
  if (request.target == kSession) return web::upgrade(request);
  if (request.method == web::Request::Method::other) {
    web::Response response = web::text_response(405, "allowed: GET, HEAD");
    response.fields.emplace_back("Allow", "GET, HEAD");
    return response;
  }
  if (web::scene_target(request.target)) return std::nullopt;
  if (const auto fragment = web::qr_target(request.target)) return web::qr_page(request, *fragment);
  return shared_.web->files.answer(request);
}

void WebExchange::respond(const web::Request& request, const web::Response& response) {
  shared_.metrics.links().transports.answered(response.status);
  answering_ = true;
  leaving_ = response.close || (!request.keep_alive && response.status != 101);
  progress_.answers(Clock::now());
  set_deadline();
  web::Response told = response;
  told.close = leaving_;
  stream_.send_bytes(web::header_of(
      told, told.status < 400 && shared_.config.web.webtransport ? data_ports_at(request.host) : ""));
  if (auto body = web::body_for(request, response)) stream_.send_bytes(std::move(body));
}

void WebExchange::leave() {
  const auto stream = std::static_pointer_cast<ControlStream>(stream_.shared_from_this());
  if (pending_.remove(stream.get())) pending_.close_gracefully(stream, Clock::now());
}

void WebExchange::set_deadline() { pending_.set_deadline(&stream_, progress_.deadline()); }

}  // namespace gnomon::daemon
