//! Account and password: from a prompt or the environment, never from the command line, where other users could read them.

use std::io::{BufRead, IsTerminal, Write};
use std::process::{Command, Stdio};

use ac_client::net::transport::{AuthType, LoginRequest};
use miette::Diagnostic;
use thiserror::Error;

/// Environment variables.
pub const ACCOUNT: &str = "AC_ACCOUNT";
/// Environment variable of the password.
pub const PASSWORD: &str = "AC_PASSWORD";

/// Where account and password come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum AccountSource {
    /// The environment variables AC_ACCOUNT and AC_PASSWORD.
    Env,
    /// Two questions; the password is not shown. Without a terminal two lines of standard input.
    Prompt,
}

/// Which kind of server the login is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum ServerKind {
    /// ACE, and this program's demonstration server: the password in a field of its own.
    #[default]
    Ace,
    /// GDLE: the password behind the account's name.
    Gdle,
}

/// Why there is no account.
#[derive(Debug, Error, Diagnostic)]
pub enum AccountError {
    /// A variable is not set.
    #[error("the environment variable {0} is not set")]
    #[diagnostic(help("set AC_ACCOUNT and AC_PASSWORD, or use --account-from prompt"))]
    Variable(&'static str),
    /// Nothing was entered.
    #[error("no {0} was entered")]
    Empty(&'static str),
    /// The terminal cannot be read.
    #[error("cannot read the {what}: {source}")]
    Input {
        /// What was asked for.
        what: &'static str,
        /// What the system says.
        source: std::io::Error,
    },
}

/// An account and its password. It is never printed.
#[derive(Clone)]
pub struct Account {
    name: String,
    password: String,
}

impl core::fmt::Debug for Account {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Account")
    }
}

impl Account {
    /// An account of these texts.
    pub fn new(name: impl Into<String>, password: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            password: password.into(),
        }
    }

    /// Asks for an account.
    ///
    /// # Errors
    /// When there is none.
    pub fn from(source: AccountSource) -> Result<Self, AccountError> {
        match source {
            AccountSource::Env => {
                let variable = |name| std::env::var(name).map_err(|_| AccountError::Variable(name));
                Ok(Self::new(variable(ACCOUNT)?, variable(PASSWORD)?))
            }
            AccountSource::Prompt => {
                let name = ask("account", false)?;
                Ok(Self::new(name, ask("password", true)?))
            }
        }
    }

    /// The login that a kind of server wants.
    pub fn login(&self, kind: ServerKind, timestamp: u32) -> LoginRequest {
        let (auth, auth_flags, account, secret) = match kind {
            ServerKind::Ace => {
                let secret = Some(self.password.clone());
                (AuthType::Password, 1, self.name.clone(), secret)
            }
            ServerKind::Gdle => {
                let account = format!("{}:{}", self.name, self.password);
                (AuthType::Account, 0, account, None)
            }
        };
        LoginRequest {
            version: "1802".into(),
            auth,
            auth_flags,
            timestamp,
            account,
            account_override: String::new(),
            secret,
        }
    }
}

/// Asks a question on standard error and reads a line.
fn ask(what: &'static str, hidden: bool) -> Result<String, AccountError> {
    let failed = |source| AccountError::Input { what, source };
    let terminal = std::io::stdin().is_terminal();
    if terminal {
        eprint!("{what}: ");
        std::io::stderr().flush().map_err(failed)?;
    }
    let hide = terminal && hidden && echo(false);
    let mut line = String::new();
    let read = std::io::stdin().lock().read_line(&mut line);
    if hide {
        echo(true);
        eprintln!();
    }
    read.map_err(failed)?;
    let line = line.trim_end_matches(['\r', '\n']).to_owned();
    if line.is_empty() {
        return Err(AccountError::Empty(what));
    }
    Ok(line)
}

/// Switches the terminal's echo; `false` where that cannot be done.
fn echo(on: bool) -> bool {
    Command::new("stty")
        .arg(if on { "echo" } else { "-echo" })
        .stdin(Stdio::inherit())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_of_server_gets_its_login() {
        let account = Account::new("tester", "secret");
        let ace = account.login(ServerKind::Ace, 1);
        assert_eq!(
            (ace.account.as_str(), ace.secret.as_deref()),
            ("tester", Some("secret"))
        );
        let gdle = account.login(ServerKind::Gdle, 1);
        assert_eq!(
            (gdle.account.as_str(), gdle.secret),
            ("tester:secret", None)
        );
        assert!(ace.to_bytes().is_ok() && !format!("{account:?}").contains("secret"));
    }
}
