// A library that is no extension.

extern "C" __attribute__((visibility("default"))) int aprsim_nothing() { return 0; }
