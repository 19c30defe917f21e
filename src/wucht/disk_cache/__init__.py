"""A cache on disk of derived equations and machine code for the next process, in the user's cache folder.

Set ``WUCHT_CACHE_DIR`` for another folder. What is read there becomes equations and machine code. So each entry has a code of
authentication (HMAC, RFC 2104) of its name and its content, by a key of the user that lies elsewhere: what another account, an
archive or a damaged disk has put there is not loaded, but derived again. Where no key can be kept, the cache is not used.
"""

from wucht.disk_cache.derived import derived_once as derived_once
from wucht.disk_cache.derived import program_state as program_state
from wucht.disk_cache.entries import cache_folder as cache_folder
from wucht.disk_cache.entries import read_entry as read_entry
from wucht.disk_cache.entries import store_entry as store_entry
