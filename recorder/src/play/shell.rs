//! UDP around the scripted client.
