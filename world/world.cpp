namespace aprsim {}
