namespace aprsim::crcl {}
