//! Account and password: from a prompt or the environment, never from the command line.
