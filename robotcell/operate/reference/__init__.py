"""A controller that keeps the rules of docs/operating.md, behind servers of Modbus TCP and OPC UA."""
