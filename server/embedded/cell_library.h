#ifndef APRSIM_CELL_LIBRARY_H
#define APRSIM_CELL_LIBRARY_H

/* The cell as a library of the caller's process: no threads, no sockets, no clock. For any language
 * that can call C. One cell belongs to one thread at a time; cells are independent of each other,
 * so each thread may step its own. Lengths are in m, angles in rad, forces in N, torques in Nm. */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct aprsim_cell aprsim_cell;

/* From now on, this process looks up the libraries of scenes' devices in this directory, too. */
void aprsim_cell_add_extensions(const char* directory);

/* Opens a cell: `scene` is the name of a shipped scene or the path of a file. `seed`: null = the
 * scene's. Returns null when the scene cannot be used; aprsim_error() tells why. */
aprsim_cell* aprsim_cell_open(const char* scene, const uint64_t* seed);
void aprsim_cell_close(aprsim_cell* cell);

/* The cause of the latest failure of this thread; valid until its next call. */
const char* aprsim_error(void);

/* Performs a call of the services aprsim.v1 that has one request and one answer. `method`: such as
 * "Control/Step". Returns a gRPC status code, 0 = OK. Answers belong to the cell and are valid
 * until its next call. */
int aprsim_cell_call(aprsim_cell* cell, const char* method, const void* request, size_t size,
                     const void** answer, size_t* answer_size);

/* Sends CRCL documents to a robot, and returns the statuses that it has answered since. Returns 0,
 * or a gRPC status code: the connection has ended, and aprsim_robot_connect begins another. */
int aprsim_robot_send(aprsim_cell* cell, size_t robot, const void* documents, size_t size,
                      const void** statuses, size_t* statuses_size);
int aprsim_robot_connect(aprsim_cell* cell, size_t robot);

/* Takes steps. Returns 0, or a gRPC status code when the simulation has stopped on a fault. */
int aprsim_cell_step(aprsim_cell* cell, uint64_t steps);

/* Keeps the present state, replacing the one of before, and returns to it, with the same bits. */
int aprsim_cell_keep(aprsim_cell* cell);
int aprsim_cell_return(aprsim_cell* cell);

/* The arrays of aprsim_cell_array. Rows are those of the description (GetCell): bodies, robots, or
 * all joints of the first robot, then of the second. */
enum aprsim_array {
  APRSIM_BODY_POSE,     /* n x 7: position, quaternion w x y z, in world */
  APRSIM_BODY_VELOCITY, /* n x 6: linear of the frame's origin, angular, in world */
  APRSIM_JOINT,         /* n x 3: position, velocity, torque */
  APRSIM_TOOL_POSE,     /* n x 7: of the tool frame, in world */
  APRSIM_TOOL_LOAD,     /* n x 6: force and torque, in the robot's reference frame */
  APRSIM_GRIPPER, /* n x 5: separation, force of both pads, holding (0 or 1), held body (-1 = none)
                   */
  APRSIM_ARRAY_COUNT
};

/* An array of the cell's state: numbers, and how many. It stays at its place until the cell's
 * bodies change, and can be read until it is closed; aprsim_cell_observe writes the present values
 * into all arrays. */
const double* aprsim_cell_array(aprsim_cell* cell, int array, size_t* size);
void aprsim_cell_observe(aprsim_cell* cell);

/* Steps since reset, and the hash of the physical state as the daemon gives it. */
uint64_t aprsim_cell_step_count(const aprsim_cell* cell);
uint64_t aprsim_cell_state_hash(const aprsim_cell* cell);

#ifdef __cplusplus
}
#endif

#endif
