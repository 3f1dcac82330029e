// Debian's gRPC and protobuf are built without ThreadSanitizer, which therefore sees none of the
// synchronisation inside them and takes every hand-over through them for a race.

extern "C" const char* __tsan_default_suppressions();  // NOLINT(bugprone-reserved-identifier)

extern "C" const char* __tsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "race:libgrpc.so\n"
         "race:libgrpc++.so\n"
         "race:libgpr.so\n"
         "race:libabsl\n"
         "race:libprotobuf.so\n"
         "race:^grpc::\n"
         "race:^google::protobuf::\n"
         "race:grpc_core::\n"
         "called_from_lib:libgrpc.so\n"
         "called_from_lib:libgrpc++.so\n"
         "called_from_lib:libgpr.so\n"
         "called_from_lib:libprotobuf.so\n";
}
