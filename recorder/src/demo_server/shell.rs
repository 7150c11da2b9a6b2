//! UDP around the server.
