namespace aprsim::modbus {}
