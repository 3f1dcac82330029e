"""PLCs of belts by Modbus/TCP."""
