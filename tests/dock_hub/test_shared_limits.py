"""Each bound of a hub is of sites: no user makes more of them, so none takes another's place."""

from tests.support.bounds import OF_HUB, bounds

OF_SITES = {
    "directory:Directory.judge",
    "follower:Follower._note",
    "follower:Follower._make_room",
    "site_view:SiteView.put_robots",
    "sites:Sites._on_hello",
}


def test_the_list_has_every_bound() -> None:
    assert bounds(OF_HUB) == OF_SITES
