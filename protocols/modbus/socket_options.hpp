#pragma once

namespace aprsim::protocols {

/// Prepares an accepted TCP socket: no Nagle delay, a peer that has gone without a word is noticed
/// within some 11 s (keepalive 5 s, then 3 probes 2 s apart; unacknowledged data 10 s), and the
/// kernel keeps a bounded amount of replies. Best effort: an option that fails stays at its
/// default.
void prepare_peer_socket(int fd);

}  // namespace aprsim::protocols
