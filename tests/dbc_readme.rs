//! The message table in dbc/README.md is the one that the DBC gives.

use canloop::schema::Profile;

const README: &str = include_str!("../dbc/README.md");

#[test]
fn the_readme_shows_the_messages_of_the_dbc() {
    let table = Profile::builtin("wheel_drive").unwrap().dbc.markdown_table();
    let (_, rest) = README.split_once("a test compares -->\n").expect("the table has a beginning");
    let (shown, _) = rest.split_once("<!-- end -->").expect("the table has an end");
    assert_eq!(shown, table, "put this between the marks of dbc/README.md:\n\n{table}");
}
