include(GNUInstallDirs)
install(TARGETS gnomon-cli)
